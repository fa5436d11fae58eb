// sftd as a whole: that there is one, its memory, its sign in /dev/shm, and its end.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "shm_transport/file_lock.h"
#include "shm_transport/sftd/exit_code.h"
#include "shm_transport/sftd/groups.h"
#include "shm_transport/sftd/host_memory.h"
#include "shm_transport/sftd/log.h"
#include "shm_transport/sftd/roudi_host.h"
#include "shm_transport/sftd/settings.h"

namespace sft::shm {

struct StartFailure {
  ExitCode code;
  std::string message;
};

class Daemon {
 public:
  using Started = tl::expected<std::unique_ptr<Daemon>, StartFailure>;
  static Started start(const DaemonSettings& settings, const Log& log);

  enum class End {
    stopped,  ///< by a signal
    idle,     ///< no clients for so long
    renew,  ///< no clients, and chunks of killed ones cannot be found: to be started again with fresh memory
  };
  /// What it took, in one sentence.
  std::string description() const;

  /// Until one of these. The signals that stop it must be blocked in all threads.
  End serve();

  /// Removes every name of this daemon. The memory itself is left as it is, for processes that still have it
  /// mapped: it goes with the last of them. Afterwards this process must exit without destroying anything.
  void remove_traces();

 private:
  Daemon(const DaemonSettings& settings, const Log& log, FileLock only_one, FileLock host_file,
         Groups groups);
  std::optional<StartFailure> host(const PoolPlan& plan);
  bool announce();
  Result<void> admit_readers();
  void tell_status();
  std::optional<End> check_idle(std::chrono::steady_clock::time_point now);

  const DaemonSettings settings_;
  const Log& log_;
  FileLock only_one_;   ///< of this /tmp
  FileLock host_file_;  ///< of this /dev/shm
  const Groups groups_;
  const std::int64_t since_ns_;
  PoolPlan plan_;
  bool status_was_told_ = true;  ///< at the last attempt

  iox::cxx::GenericRAII error_handler_;
  std::optional<iox::posix::FileLock> roudi_lock_;  ///< keeps an iox-roudi from taking our segments away
  std::unique_ptr<HostMemory> memory_;
  std::unique_ptr<iox::roudi::PortManager> ports_;
  std::unique_ptr<RoudiHost> roudi_;
  std::optional<std::chrono::steady_clock::time_point> idle_since_;
};

}  // namespace sft::shm
