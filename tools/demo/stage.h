// The hosts of the demo, and the roles on them.
//
//   host "lidar"     the publisher, and the detector
//   host "monitor"   health              host "cockpit"  dashboard
//   host "logger"    recorder            host "nav"      localiser
//
// A host is a process tree, with a process for each role. Where namespaces can be made, it looks like a
// machine of its own to all programs on it, on an emulated network. Otherwise all roles are processes on this
// machine, and those that would be remote can use only UDP.
//
// The first process of the tree outlives the roles, adopts the processes that they leave behind (the daemon
// of the shared memory) and ends these, so that no process goes on that the demo has started. If the demo
// itself is killed, the kernel ends the first process.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tools/demo/channel.h"
#include "tools/demo/roles.h"
#include "tools/hosts/network.h"

namespace sft::demo {

class Stage {
 public:
  /// Starts all hosts. REQUIRES: the calling process has one
  /// thread.
  static Result<std::unique_ptr<Stage>> set_up(const RunOptions& options);
  /// Ends all processes that still run.
  ~Stage();
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;

  /// Returns true if the hosts are namespaces. If not, why_not() says why.
  bool real_hosts() const { return network_.has_value(); }
  const std::string& why_not() const { return why_not_; }

  Channel& subscriber(std::size_t number) { return channels_[number]; }
  Channel& publisher() { return channels_.back(); }

 private:
  Stage() = default;
  Result<void> start_host(std::size_t number, std::uint32_t domain, const RunOptions& options);

  std::string why_not_;
  std::optional<hosts::EmulatedNetwork> network_;
  std::vector<pid_t> first_processes_;
  std::vector<Channel> channels_;
};

}  // namespace sft::demo
