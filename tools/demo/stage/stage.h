// The hosts of the example, and the roles on them.
//
//   host "lidar"     the publisher, and the detector
//   host "monitor"   health              host "cockpit"  dashboard
//   host "logger"    recorder            host "nav"      localiser
//
// Where namespaces can be made, each host has namespaces of its own, on an emulated network. Otherwise all
// roles are processes on this machine, and those that would be remote can use only UDP.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tools/demo/roles/protocol.h"
#include "tools/demo/stage/host.h"
#include "tools/hosts/network.h"

namespace sft::demo {

class Stage {
 public:
  struct Subscriber {
    std::string name;
    std::string host;
    std::string purpose;
    double max_rate_hz = 0;  ///< 0: all clouds
    bool local = false;      ///< on the host of the publisher
    Channel* channel = nullptr;
  };

  /// Starts all hosts. `arr`: subscribers record their fields. REQUIRES: the calling process has one thread.
  static Result<std::unique_ptr<Stage>> set_up(bool arr);
  /// Ends all hosts.
  ~Stage();
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;

  /// Returns true if the hosts are namespaces. If not, why_not() says why.
  bool real_hosts() const { return network_.has_value(); }
  const std::string& why_not() const { return why_not_; }
  unsigned hosts() const { return real_hosts() ? static_cast<unsigned>(hosts_.size()) : 1; }

  const std::vector<Subscriber>& subscribers() const { return subscribers_; }
  Result<PublisherReport> ask_publisher(const Order& order, const WhileWaiting& while_waiting = {});
  Result<SubscriberReport> ask(const Subscriber& subscriber, const WhileWaiting& while_waiting = {});

 private:
  Stage() = default;
  Result<void> start_hosts(bool arr);
  /// The subscriber of the host comes first.
  std::vector<Role> roles_on(std::size_t number, std::uint32_t domain, bool arr) const;

  std::string why_not_;
  std::optional<hosts::EmulatedNetwork> network_;
  std::vector<Host> hosts_;
  std::vector<Subscriber> subscribers_;
};

}  // namespace sft::demo
