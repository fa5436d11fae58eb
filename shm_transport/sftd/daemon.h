// The daemon sftd as a whole. It ensures that there is only one daemon, makes the shared memory, announces
// itself by the host file in /dev/shm, serves programs, and ends.
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
  /// A function that ends this process. It is called on any thread if iceoryx reports, before the daemon
  /// has started, that it cannot continue. iceoryx would crash otherwise.
  using EndProcess = std::function<void(const StartFailure& why)>;
  static Started start(const DaemonSettings& settings, const Log& log, EndProcess end);

  enum class End {
    stopped,  ///< a signal stopped the daemon
    idle,     ///< the daemon had no clients for the time in the settings
    /// The daemon must start afresh for one of two reasons. No program can join, because the daemon's files
    /// have been removed. Or the daemon has no clients, and cannot find the chunks that killed clients have
    /// lost.
    renew,
  };
  /// Returns a sentence about the memory that the daemon has taken.
  std::string description() const;

  /// Serves until there is a reason to end, and returns that reason. The signals that stop the daemon must
  /// be blocked in all threads.
  End serve();

  /// Removes the files of this daemon (OwnFiles::remove_all()). The memory itself stays for the processes
  /// that still have it mapped, and is freed with the last mapping. After this call the process must exit
  /// without destroying any object.
  void remove_files(bool starts_again) { files_.remove_all(starts_again); }
  /// Waits until the programs that still use this daemon have noticed that it is gone. Called after
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
  bool status_was_written_ = true;  ///< true if the last attempt to write the status succeeded
  bool files_removed_ = false;      ///< true if files of this daemon were removed, so no program can join

  IceoryxErrors errors_;
  /// A lock that keeps an iox-roudi from replacing the segments.
  std::optional<iox::posix::FileLock> roudi_lock_;
  std::unique_ptr<HostMemory> memory_;
  PageClearer clearer_;
  std::unique_ptr<iox::roudi::PortManager> ports_;
  std::unique_ptr<RoudiHost> roudi_;
  std::optional<std::chrono::steady_clock::time_point> idle_since_;
};

}  // namespace sft::shm
