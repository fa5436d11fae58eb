// The hosts of the demo, and the roles on them.
//
//   host "lidar"     the publisher, and the detector
//   host "monitor"   health              host "cockpit"  dashboard
//   host "logger"    recorder            host "nav"      localiser
//
// A host is a process tree, with a process for each role. If namespaces can be made, a host looks like a
// separate machine to all programs on it, with an emulated network. Otherwise all roles are processes on
// this machine, and the roles that would be remote can use only UDP.
//
// The first process of the tree outlives the roles. It adopts the processes that they leave running (the
// daemon of the shared memory) and ends them, so that no process of the demo remains. If the demo itself is
// killed, the kernel ends the first process.
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
