// sftd as a whole: that there is one, its memory, its sign in /dev/shm, and its end.
#pragma once

#include <sys/types.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "shm_transport/host/file_lock.h"
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
  /// `end`: ends this process. Called from any thread where iceoryx reports, until the daemon has started,
  /// that it cannot go on: it would crash if it did.
  using EndProcess = std::function<void(const StartFailure& why)>;
  static Started start(const DaemonSettings& settings, const Log& log, EndProcess end);

  enum class End {
    stopped,  ///< by a signal
    idle,     ///< no clients for so long
    /// To be started afresh: nobody can join, since somebody removed its files; or it has no clients, and
    /// chunks of killed ones cannot be found.
    renew,
  };
  /// What it took, in one sentence.
  std::string description() const;

  /// Until one of these. The signals that stop it must be blocked in all threads.
  End serve();

  /// Removes every name of this daemon. The memory itself is left as it is, for processes that still have it
  /// mapped: it goes with the last of them. Afterwards this process must exit without destroying anything.
  void remove_traces(bool starts_again);
  /// Before it starts afresh, after that: programs that still use it notice that it is gone.
  void await_users();

 private:
  Daemon(const DaemonSettings& settings, const Log& log, FileLock only_one, FileLock host_file,
         Groups groups);
  std::optional<StartFailure> host(const PoolPlan& plan);
  bool announce();
  Result<void> admit_readers();
  void tell_status();
  void note_segments();
  bool has_lost_its_names() const;
  void look_after_names();
  std::optional<End> check_idle(std::chrono::steady_clock::time_point now);

  const DaemonSettings settings_;
  const Log& log_;
  FileLock only_one_;   ///< of this /tmp
  FileLock host_file_;  ///< of this /dev/shm
  const Groups groups_;
  const std::int64_t since_ns_;
  const std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
  PoolPlan plan_;
  bool status_was_told_ = true;  ///< at the last attempt
  dev_t shm_device_ = 0;         ///< the file system that these are in
  bool names_lost_ = false;      ///< somebody removed its files: nobody can join any more
  std::vector<std::pair<std::string, ino_t>> segments_;  ///< their names

  iox::cxx::GenericRAII error_handler_;
  std::optional<iox::posix::FileLock> roudi_lock_;  ///< keeps an iox-roudi from taking our segments away
  std::unique_ptr<HostMemory> memory_;
  std::unique_ptr<iox::roudi::PortManager> ports_;
  std::unique_ptr<RoudiHost> roudi_;
  std::optional<std::chrono::steady_clock::time_point> idle_since_;
};

}  // namespace sft::shm
