// A host of the demo: a process tree that runs one or more roles, each in a process of its own. Where
// namespaces are to be had it is a machine of its own to whatever runs there (see isolation.h); otherwise it
// is just processes on this one.
//
// The first process of the tree outlives the roles, adopts what they leave behind (the daemon of the shared
// memory) and ends that, so that nothing the demo started goes on. If the demo itself is killed, the kernel
// ends the first process.
#pragma once

#include <chrono>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "examples/demo/channel.h"
#include "examples/demo/isolation.h"

namespace sft::demo {

/// What a process of a host does: talks with the demo through its end of the channel until that closes.
struct Role {
  std::string name;
  std::function<void(Channel&)> run;
};

class Host {
 public:
  /// Starts all roles; on this machine if there is no network in the settings. REQUIRES: the calling process
  /// has one thread.
  static Result<Host> start(const HostSettings& settings, const std::vector<Role>& roles);

  Host(Host&& other) noexcept
      : first_process_(std::exchange(other.first_process_, -1)), channels_(std::move(other.channels_)) {}
  Host& operator=(Host&&) = delete;
  /// Ends what still runs.
  ~Host();

  Channel& channel(std::size_t role) { return channels_[role]; }

  /// Tells the roles to end, by closing their channels. Does not wait for that: the destructor does.
  void dismiss() { channels_.clear(); }

 private:
  Host(pid_t first_process, std::vector<Channel> channels)
      : first_process_(first_process), channels_(std::move(channels)) {}

  pid_t first_process_;
  std::vector<Channel> channels_;
};

}  // namespace sft::demo
