// The processes that have registered with the daemon, and which of them are dead.
//
// A process is known by its runtime name, which is also the name of its socket in /tmp. It is dead when no
// process listens on this socket any more. Its pid only tells when to look at the socket, because the pid of
// a process in another container can belong to another process here. The pid decides only if this user may
// not ask the socket, or if somebody has removed the socket.
#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "core/sync/mutex.h"
#include "shm_transport/host/file_lock.h"

namespace sft::shm {

class ClientTable {
 public:
  using Clock = std::chrono::steady_clock;

  // Any thread may call these functions; find_dead() one thread at a time.
  void add(const std::string& name, pid_t pid);
  void remove(const std::string& name);
  bool empty() const;
  std::size_t size() const;

  struct Client {
    std::string name;
    pid_t pid;  ///< as the process gave it, in its own pid namespace
  };
  std::vector<Client> all() const;

  /// Returns the registered processes that are dead. A call costs one system call while no process dies, and
  /// once in a second one more for each process.
  std::vector<std::string> find_dead(Clock::time_point now);

  /// Returns whether this process can do nothing any more: it is dead, or is not registered.
  bool is_gone(const std::string& name) const;

 private:
  /// `life`: a pidfd, which becomes readable when the process is gone. There is none for a pid of another
  /// namespace.
  struct Process {
    pid_t pid = 0;
    std::shared_ptr<const Descriptor> life{};
  };
  static bool is_dead(const std::string& name, const Process& process, bool exited);

  mutable core::Mutex mutex_;
  std::map<std::string, Process> clients_ SFT_GUARDED_BY(mutex_);
  Clock::time_point next_round_{};  ///< when find_dead() looks at all sockets again; only find_dead() uses it
};

}  // namespace sft::shm
