// The daemon sftd as a whole. It makes sure that there is only one daemon, makes the shared memory, announces
// itself by the host file in /dev/shm, serves, and ends.
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
  /// Ends this process. It is called from any thread if iceoryx reports, before the daemon has started, that
  /// it cannot go on; iceoryx would crash otherwise.
  using EndProcess = std::function<void(const StartFailure& why)>;
  static Started start(const DaemonSettings& settings, const Log& log, EndProcess end);

  enum class End {
    stopped,  ///< a signal stopped the daemon
    idle,     ///< the daemon had no clients for as long as the settings say
    /// The daemon must start afresh: no program can join, because somebody has removed its files; or it has
    /// no clients, and the lost chunks of killed clients cannot be found.
    renew,
  };
  /// Describes in one sentence how much memory the daemon has taken.
  std::string description() const;

  /// Serves until one of these reasons to end. The signals that stop the daemon must be blocked in all
  /// threads.
  End serve();

  /// Removes every file of this daemon. The memory itself stays for the processes that still have it mapped,
  /// and goes with the last of them. After this call the process must exit without destroying anything.
  void remove_files(bool starts_again);
  /// Waits until the programs that still use this daemon have noticed that it is gone. It is called after
  /// remove_files(), if the daemon starts afresh.
  void let_users_notice();

 private:
  Daemon(const DaemonSettings& settings, const Log& log, FileLock daemon_lock, FileLock host_file,
         Groups groups);
  std::optional<StartFailure> host(const PoolPlan& plan);
  bool announce();
  Result<void> admit_readers();
  void write_status();
  void note_segments();
  bool names_are_removed() const;
  void check_names();
  std::optional<End> check_idle(std::chrono::steady_clock::time_point now);

  const DaemonSettings settings_;
  const Log& log_;
  FileLock daemon_lock_;  ///< keeps other daemons out of this /tmp
  FileLock host_file_;    ///< keeps other daemons out of this /dev/shm
  const Groups groups_;
  const std::int64_t since_ns_;
  const std::chrono::steady_clock::time_point began_ = std::chrono::steady_clock::now();
  PoolPlan plan_;
  bool status_was_written_ = true;  ///< at the last attempt
  dev_t shm_device_ = 0;            ///< the file system of the segments
  bool names_removed_ = false;      ///< somebody has removed files of this daemon; nobody can join
  std::vector<std::pair<std::string, ino_t>> segments_;  ///< the path and the inode of each segment

  iox::cxx::GenericRAII error_handler_;
  std::optional<iox::posix::FileLock> roudi_lock_;  ///< keeps an iox-roudi from replacing the segments
  std::unique_ptr<HostMemory> memory_;
  std::unique_ptr<iox::roudi::PortManager> ports_;
  std::unique_ptr<RoudiHost> roudi_;
  std::optional<std::chrono::steady_clock::time_point> idle_since_;
};

}  // namespace sft::shm
