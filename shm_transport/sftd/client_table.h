// A table of the processes that have registered with the daemon. The table finds out which of them are
// dead.
//
// A process is identified by its runtime name, which is also the name of its socket in /tmp. The name shows
// whether the process is in the daemon's pid namespace. If so, the process counts as dead when its pid is
// gone: a forked copy of the process may still have the socket. The pid of a process in another container
// can be that of a different process here. So the end of that pid is only a reason to check the socket, and
// the process counts as dead when no process listens at the socket any more. The pid alone decides only if
// this user lacks the right to query the socket, or if another process has removed the socket.
#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/sync/mutex.h"
#include "shm_transport/host/file_lock.h"
#include "shm_transport/host/host_file.h"

namespace sft::shm {

class ClientTable {
 public:
  using Clock = std::chrono::steady_clock;

  // Any thread may call the following functions, but only one thread at a time may call find_dead().
  void add(const std::string& name, pid_t pid);
  void remove(const std::string& name);
  bool empty() const;
  std::size_t size() const;

  struct Client {
    std::string name;
    pid_t pid;  ///< the process id that the process reported, in its own pid namespace
  };
  std::vector<Client> all() const;

  /// Returns the registered processes that are dead. As long as no process dies, a call makes one system
  /// call, and once per second an additional one for each process.
  std::vector<std::string> find_dead(Clock::time_point now);

  /// Returns whether the process is dead, or is not registered.
  bool is_gone(const std::string& name) const;

 private:
  /// A registered process. `life` is a pidfd, which becomes readable when the process is gone; invalid if
  /// no process here has that pid. `has_own_pids` is true if the process is in the daemon's pid namespace.
  struct Process {
    pid_t pid = 0;
    bool has_own_pids = false;
    std::shared_ptr<const Descriptor> life{};
  };
  static bool is_dead(const std::string& name, const Process& process, bool exited);

  const std::string own_mark_ = pid_namespace_mark();
  mutable core::Mutex mutex_;
  std::map<std::string, Process> clients_ SFT_GUARDED_BY(mutex_);
  Clock::time_point next_round_{};  ///< time of the next check of all sockets; used only by find_dead()
};

}  // namespace sft::shm
