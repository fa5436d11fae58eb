// The hosts of the example, and the roles on them.
//
//   host "lidar"     the publisher, and the detector
//   host "monitor"   health              host "cockpit"  dashboard
//   host "logger"    recorder            host "nav"      localiser
//
// Where namespaces can be made, each host has namespaces of its own, on an emulated network. Otherwise all
// roles are processes on this machine, and those that would be remote may use UDP only.
#pragma once

#include <sys/types.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tools/demo/roles/roles.h"
#include "tools/demo/stage/host.h"

namespace sft::demo {

class Stage {
 public:
  struct Subscriber {
    std::string name;
    std::string host;
    std::string purpose;
    bool local = false;  ///< on the host of the publisher
    SubscriberReport report{};
    Route route{};  ///< the way of its samples, as the publisher sees it
  };

  /// Starts all hosts. REQUIRES: the calling process has one thread.
  static Result<std::unique_ptr<Stage>> set_up(const PublishingPlan& plan, bool arr);
  /// Ends all hosts, and waits until they have ended.
  ~Stage();
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;

  /// True if the hosts are namespaces. If not, why_not() says why.
  bool real_hosts() const { return network_.has_value(); }
  const std::string& why_not() const { return why_not_; }
  unsigned hosts() const { return real_hosts() ? static_cast<unsigned>(processes_.size()) : 1; }

  void order(Order order) { board_->order = order; }
  /// Reads what the roles report. An error if one of them has ended.
  Result<void> update();
  const std::vector<Subscriber>& subscribers() const { return subscribers_; }
  const PublisherReport& publisher() const { return publisher_; }

 private:
  explicit Stage(Board* board) : board_(board) {}
  Result<void> start(const PublishingPlan& plan, bool arr);

  Board* board_;  // in memory that all processes share
  std::string why_not_;
  std::optional<hosts::EmulatedNetwork> network_;
  std::vector<pid_t> processes_;  // the first one of each host
  std::vector<Subscriber> subscribers_;
  PublisherReport publisher_;
};

}  // namespace sft::demo
