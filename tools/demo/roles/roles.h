// The roles of the example, each in a process of its own. They report to the demo until it orders the end.
// The error of a role that cannot go on is what it returns.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sft/options.h"
#include "sft/result.h"
#include "tools/demo/clouds/point_cloud_files.h"
#include "tools/demo/roles/protocol.h"

namespace sft {
class Node;
}

namespace sft::demo {

struct NodePlan {
  std::string name;
  std::uint32_t domain = 0;
  TransportChoice transport = TransportChoice::automatic;
  std::optional<std::string> interface {};  ///< its traffic is measured; empty: nothing is measured
};

Result<Node> open_node(const NodePlan& plan);

struct PublishingPlan {
  Clouds clouds{};
  double hz = 10;
  std::uint64_t samples = 100;
};

/// The lidar publishes when the demo orders it.
Result<void> run_publisher(const NodePlan& node, const PublishingPlan& plan, Board& board);

/// A subscriber reads its fields in the callback, and counts what came.
struct SubscriberRole {
  const char* name;
  const char* purpose;
  /// It reports as the subscriber of that number.
  Result<void> (*run)(const NodePlan& node, bool is_recorded, Board& board, std::size_t number);
};

/// Those of consumers.h. The last one is the detector.
extern const std::array<SubscriberRole, 5> subscriber_roles;

/// The smallest latency that a share `q` of all latencies does not exceed (nearest rank); 0: there is none.
double percentile_us(std::vector<std::int64_t> latencies_ns, double q);

}  // namespace sft::demo
