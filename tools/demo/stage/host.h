// A host of the demo: a process tree that runs one or more roles, each in a process of its own. If namespaces
// can be made, it looks like a machine of its own to all programs on it. Otherwise it is just processes on
// this machine.
//
// The first process of the tree outlives the roles, adopts the processes that they leave behind (the daemon
// of the shared memory) and ends these, so that no process goes on that the demo has started. If the demo
// itself is killed, the kernel ends the first process.
#pragma once

#include <functional>
#include <string>
#include <utility>
#include <vector>

#include "tools/demo/roles/channel.h"
#include "tools/hosts/network.h"

namespace sft::demo {

/// The work of one process of a host: talks with the demo through its end of the channel until that closes.
struct Role {
  std::string name;
  std::function<void(Channel&)> run;
};

struct HostSettings {
  const hosts::NetworkNamespace* network = nullptr;  ///< null: the host is this machine
  unsigned shared_memory_mib = 256;                  ///< of /dev/shm; the daemon's memory depends on it
};

/// Tries in a child process whether hosts can be made. The error says why not.
Result<void> try_isolation();

/// Gets the right to make hosts, which root has. Any other user becomes root of a user namespace, if the
/// system lets users have one, for the rest of the calling process. REQUIRES: the process has one thread.
Result<void> become_root();

class Host {
 public:
  /// Starts all roles. REQUIRES: the calling process has one thread.
  static Result<Host> start(const HostSettings& settings, const std::vector<Role>& roles);

  Host(Host&& other) noexcept
      : first_process_(std::exchange(other.first_process_, -1)), channels_(std::move(other.channels_)) {}
  Host& operator=(Host&&) = delete;
  /// Ends all processes of the host that still run.
  ~Host();

  Channel& channel(std::size_t role) { return channels_[role]; }

  /// Tells the roles to end, by closing their channels. Does not wait for their end: the destructor does.
  void dismiss() { channels_.clear(); }

 private:
  Host(pid_t first_process, std::vector<Channel> channels)
      : first_process_(first_process), channels_(std::move(channels)) {}

  pid_t first_process_;
  std::vector<Channel> channels_;
};

}  // namespace sft::demo
