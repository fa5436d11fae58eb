// The daemon sftd as a whole. It makes sure that there is only one daemon, makes the shared memory, announces
// itself by the host file in /dev/shm, serves, and ends.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "shm_transport/sftd/groups.h"
#include "shm_transport/sftd/host_memory.h"
#include "shm_transport/sftd/iceoryx_errors.h"
#include "shm_transport/sftd/log.h"
#include "shm_transport/sftd/own_files.h"
#include "shm_transport/sftd/page_clearer.h"
#include "shm_transport/sftd/roudi_host.h"
#include "shm_transport/sftd/settings.h"
#include "shm_transport/sftd/start_failure.h"

namespace sft::shm {

class Daemon {
 public:
  using Started = tl::expected<std::unique_ptr<Daemon>, StartFailure>;
  /// Ends this process. It is called from any thread if iceoryx reports, before the daemon has started, that
  /// it cannot go on; iceoryx would crash otherwise.
  using EndProcess = std::function<void(const StartFailure& why)>;
  static Started start(const DaemonSettings& settings, const Log& log, EndProcess end);

  enum class End {
    stopped,  ///< a signal stopped the daemon
    idle,     ///< the daemon had no clients for as long as the settings say
    /// The daemon must start afresh: no program can join, because the daemon's files have been removed; or it
    /// has no clients, and the lost chunks of killed clients cannot be found.
    renew,
  };
  /// Describes in one sentence how much memory the daemon has taken.
  std::string description() const;

  /// Serves until one of these reasons to end. The signals that stop the daemon must be blocked in all
  /// threads.
  End serve();

  /// Removes the files of this daemon (OwnFiles::remove_all()). The memory itself stays for the processes
  /// that still have it mapped, and is freed with the last of them. After this call the process must exit
  /// without destroying anything.
  void remove_files(bool starts_again) { files_.remove_all(starts_again); }
  /// Waits until the programs that still use this daemon have noticed that it is gone. It is called after
  /// remove_files(), if the daemon starts afresh.
  void let_users_notice();

 private:
  Daemon(const DaemonSettings& settings, const Log& log, OwnFiles files, Groups groups);
  std::optional<StartFailure> host(const PoolPlan& plan);
  void end_hosting();
  bool announce();
  Result<void> admit_readers();
  void write_status();
  void check_files();
  std::optional<End> check_idle(std::chrono::steady_clock::time_point now);

  const DaemonSettings settings_;
  const Log& log_;
  OwnFiles files_;
  const Groups groups_;
  const std::int64_t since_ns_;
  const std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
  PoolPlan plan_;
  bool status_was_written_ = true;  ///< at the last attempt
  bool files_removed_ = false;      ///< files of this daemon were removed, so no program can join

  IceoryxErrors errors_;
  std::optional<iox::posix::FileLock> roudi_lock_;  ///< keeps an iox-roudi from replacing the segments
  std::unique_ptr<HostMemory> memory_;
  PageClearer clearer_;
  std::unique_ptr<iox::roudi::PortManager> ports_;
  std::unique_ptr<RoudiHost> roudi_;
  std::optional<std::chrono::steady_clock::time_point> idle_since_;
};

}  // namespace sft::shm
