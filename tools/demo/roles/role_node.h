// The parts of every role: a node, the traffic of its host, and the last warning of the library.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "core/sync/mutex.h"
#include "sft/node.h"
#include "tools/demo/roles/traffic.h"

namespace sft::demo {

struct NodePlan {
  std::string name;
  std::uint32_t domain = 0;
  TransportChoice transport = TransportChoice::automatic;
  std::optional<std::string> interface {};  ///< its traffic is measured; empty: nothing is measured
};

class RoleNode {
 public:
  static Result<std::unique_ptr<RoleNode>> open(const NodePlan& plan);

  Node& node() { return *node_; }
  /// Returns the traffic; all figures are zero if it is not measured.
  Traffic traffic() { return meter_ == nullptr ? Traffic{} : meter_->read(); }
  std::string last_warning();

 private:
  RoleNode() = default;
  void note(LogLevel level, std::string_view text);

  std::unique_ptr<TrafficMeter> meter_;
  core::Mutex mutex_;
  std::string last_warning_ SFT_GUARDED_BY(mutex_);
  std::optional<Node> node_;  // last, since its threads note warnings
};

}  // namespace sft::demo
