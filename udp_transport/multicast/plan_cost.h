// The cost model of multicast.md: what one sample of a writer costs where some of its readers are sent one
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

/// Bytes of a body that has these fields, and parts of fields.
using BodyBytes = std::function<double(const Selection&)>;

/// A process that may be in a group.
struct PlanDestination {
  Selection fields{};              ///< one_copy() for all its readers
  double alone_bytes = 0;          ///< on the wire, if what each of them asks for is sent there alone
  std::size_t division = 0;        ///< a group has members of one division (divisions.h)
  std::size_t datagram_bytes = 0;  ///< that its path takes
  /// All in its division are sent so many samples in a second, on average over some seconds. Empty: every
  /// sample.
  std::optional<double> passing_per_s{};
};

struct PlannedGroup {
  Selection fields;                  ///< sent to it: one_copy() for its members
  std::vector<std::size_t> members;  ///< ascending; places of destinations
  friend bool operator==(const PlannedGroup&, const PlannedGroup&) = default;
};
/// The groups in the order of their first members. A reader in no group is served alone.
using MulticastPlan = std::vector<PlannedGroup>;

struct PlanLimits {
  double unwanted_weight = 0.25;   ///< of a byte that a member gets and has not asked for
  double wire_max = 1.05;          ///< bytes on a link, by what one group, or none, would put there
  double gain_min = 0.05;          ///< of what another plan costs: less is no reason to change to it
  double gain_bytes_per_s = 4096;  ///< a gain of fewer bytes is no reason to change the plan
  std::size_t groups_max = 8;      ///< of a division
  /// The bytes that a body may have that nobody asked for as it is: a larger one might not be sent at all.
  double merged_body_max = std::numeric_limits<double>::infinity();
};

/// The position that a sample carries on the wire. A sample that fits into one datagram has its position in a
/// channel in the header, without more bytes.
enum class PlaceMark : std::uint8_t { none, in_channel, in_group };

/// Returns the bytes that one sample with such a body takes on the wire, with the headers of SFT, Ethernet,
/// IP and UDP.
double wire_bytes(double body_bytes, std::size_t datagram_bytes, PlaceMark place);

/// What one sample costs.
struct PlanCost {
  double cost = 0;  ///< `wire`, and the unwanted bytes by their weight
  double wire = 0;  ///< bytes on all links
  friend PlanCost operator+(PlanCost a, PlanCost b) { return {a.cost + b.cost, a.wire + b.wire}; }
  friend PlanCost operator-(PlanCost a, PlanCost b) { return {a.cost - b.cost, a.wire - b.wire}; }
};

}  // namespace sft::udp
