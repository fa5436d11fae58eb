// The cost model of multicast.md. It computes the cost of one sample of a writer if some of its readers
// share one copy.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "sft/selection.h"

namespace sft::udp {

/// Returns the length in bytes of a body with these fields and parts of fields.
using BodyBytes = std::function<double(const Selection&)>;

/// A process that may be in a group.
struct PlanDestination {
  Selection fields{};      ///< one_copy() for all readers of the process
  double alone_bytes = 0;  ///< bytes on the wire of one sample, if the process is in no group
  /// The number of the destination's division. All members of a group are of the same division
  /// (divisions.h).
  std::size_t division = 0;
  std::size_t datagram_bytes = 0;  ///< maximum length of datagrams on the path to the process
  /// The number of samples per second for its division, on average over some seconds; empty: every sample is
  /// for it.
  std::optional<double> passing_per_s{};
};

struct PlannedGroup {
  Selection fields;                  ///< content of the copy for the group: one_copy() for its members
  std::vector<std::size_t> members;  ///< indices of destinations, ascending
  friend bool operator==(const PlannedGroup&, const PlannedGroup&) = default;
};
/// The groups in the order of their first members. A destination in no group gets its own copies.
using MulticastPlan = std::vector<PlannedGroup>;

struct PlanLimits {
  /// Cost of a byte that a member did not request, relative to a byte on the wire.
  double unwanted_weight = 0.25;
  double wire_max = 1.05;  ///< maximum bytes on a link, relative to one group for all or no group
  /// A plan with a smaller gain, relative to the cost of the present plan, is not adopted.
  double gain_min = 0.05;
  double gain_bytes_per_s = 4096;  ///< a plan that saves fewer bytes per second is not adopted
  std::size_t groups_max = 8;      ///< the maximum number of groups in a division
  /// The maximum length in bytes of a merged body, unless a reader requests exactly its fields. A larger
  /// body might be too large to be sent.
  double merged_body_max = std::numeric_limits<double>::infinity();
};

/// The ordinal that a sample carries on the wire: none, in a channel, or in a group. In a sample that fits
/// into one datagram, the ordinal in a channel takes no additional bytes.
enum class PlaceMark : std::uint8_t { none, in_channel, in_group };

/// Returns the size on the wire of one sample with a body of that length, in bytes, with the headers of SFT,
/// Ethernet, IP and UDP.
double wire_bytes(double body_bytes, std::size_t datagram_bytes, PlaceMark place);

/// The cost of one sample.
struct PlanCost {
  double cost = 0;  ///< `wire` plus the weighted unwanted bytes
  double wire = 0;  ///< bytes on all links
  friend PlanCost operator+(PlanCost a, PlanCost b) { return {a.cost + b.cost, a.wire + b.wire}; }
  friend PlanCost operator-(PlanCost a, PlanCost b) { return {a.cost - b.cost, a.wire - b.wire}; }
};

}  // namespace sft::udp
