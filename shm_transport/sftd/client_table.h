// The processes that registered, and which of them are dead.
//
// A process is known by its runtime name, which is also the name of its socket in /tmp. It is dead when
// nobody listens there any more. Its pid tells when to look, and decides only where this user may not ask the
// socket, or somebody has removed it: processes of other containers have pids that mean something else here.
#pragma once

#include <chrono>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "shm_transport/host/file_lock.h"

namespace sft::shm {

class ClientTable {
 public:
  using Clock = std::chrono::steady_clock;

  // Any thread, but find_dead one at a time.
  void add(const std::string& name, pid_t pid);
  void remove(const std::string& name);
  bool empty() const;
  std::size_t size() const;

  struct Client {
    std::string name;
    pid_t pid;  ///< as it told
  };
  std::vector<Client> all() const;

  /// The dead ones among the registered. Cheap while nobody dies: one system call, and one per client each
  /// second.
  std::vector<std::string> find_dead(Clock::time_point now);

  /// Whether this process can no longer do anything: never registered, or registered and dead.
  bool is_gone(const std::string& name) const;

 private:
  /// `life`: a pidfd, readable once the process is gone; none for pids of other namespaces.
  struct Process {
    pid_t pid = 0;
    std::shared_ptr<const Descriptor> life{};
  };
  static bool is_dead(const std::string& name, const Process& process, bool exited);

  mutable std::mutex mutex_;  // guards the map
  std::map<std::string, Process> clients_;
  Clock::time_point next_round_{};  ///< of the one thread that looks for the dead
};

}  // namespace sft::shm
