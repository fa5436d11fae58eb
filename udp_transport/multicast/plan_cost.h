// The cost model of multicast.md: what one sample of a writer costs if some of its readers are sent one
// copy together.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <limits>
#include <optional>
#include <vector>

#include "sft/selection.h"

namespace sft::udp {

/// Returns the bytes of a body that has these fields and parts of fields.
using BodyBytes = std::function<double(const Selection&)>;

/// A process that may be in a group.
struct PlanDestination {
  Selection fields{};      ///< one_copy() for all readers of the process
  double alone_bytes = 0;  ///< bytes on the wire of one sample, if the process is served alone
  /// Number of the division; all members of a group have the same one (divisions.h).
  std::size_t division = 0;
  std::size_t datagram_bytes = 0;  ///< length of datagrams that the path to it takes
  /// Samples per second that pass for its division, on average over some seconds. Empty: every sample
  /// passes.
  std::optional<double> passing_per_s{};
};

struct PlannedGroup {
  Selection fields;                  ///< content of the copy for the group: one_copy() for its members
  std::vector<std::size_t> members;  ///< indices of destinations, ascending
  friend bool operator==(const PlannedGroup&, const PlannedGroup&) = default;
};
/// The groups in the order of their first members. A reader in no group is served alone.
using MulticastPlan = std::vector<PlannedGroup>;

struct PlanLimits {
  double unwanted_weight = 0.25;  ///< cost of a byte that a member did not request, relative to other bytes
  double wire_max = 1.05;         ///< limit of the bytes on a link, relative to one group or none
  /// A plan with a smaller gain, relative to the cost of the present plan, is not adopted.
  double gain_min = 0.05;
  double gain_bytes_per_s = 4096;  ///< a plan that saves fewer bytes per second is not adopted
  std::size_t groups_max = 8;      ///< the largest number of groups in a division
  /// The limit in bytes of a merged body that no reader requests as it is. A larger body might be too large
  /// to be sent.
  double merged_body_max = std::numeric_limits<double>::infinity();
};

/// The place that a sample carries on the wire. A sample that fits into one datagram has its place in a
/// channel in the header, without further bytes.
enum class PlaceMark : std::uint8_t { none, in_channel, in_group };

/// Returns the bytes on the wire of one sample with a body of that length, including the headers of SFT,
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
