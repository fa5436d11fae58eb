// Decides which readers of a writer are sent one copy together, by the cost model of multicast.md. It is
// pure: sizes go in, a partition comes out.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <vector>

namespace sft::udp {

/// Some of the writer's distinct masks, each a bit; as a mask of its own: their union.
using MaskSet = std::uint32_t;

/// Bytes of a body that has the fields of all these masks.
using BodyBytes = std::function<double(MaskSet)>;

/// A process that may be in a group.
struct PlanDestination {
  MaskSet masks = 0;               ///< one copy each goes there, unless it is in a group
  std::size_t link = 0;            ///< a group is behind one link
  std::size_t datagram_bytes = 0;  ///< that its path takes
  bool reliable = false;
};

struct PlannedGroup {
  MaskSet masks = 0;                 ///< sent to it: all those of its members
  std::vector<std::size_t> members;  ///< ascending; places of destinations
  friend bool operator==(const PlannedGroup&, const PlannedGroup&) = default;
};
/// The groups in the order of their first members. A reader in no group is served alone.
using MulticastPlan = std::vector<PlannedGroup>;

struct PlanLimits {
  double unwanted_weight = 0.25;   ///< of a byte that a member gets and has not asked for
  double gain_min = 0.15;          ///< of the present cost: less is no reason to change anything
  double gain_bytes_per_s = 4096;  ///< likewise
  std::size_t groups_max = 4;
  std::size_t kinds_max = 7;  ///< of destinations, by masks; the rarest of more are served alone
};

/// The position that a sample carries. A position in a channel takes bytes of its own only if the sample does
/// not fit into one datagram.
enum class PlaceMark : std::uint8_t { none, in_channel, in_group };

/// Bytes on the wire of one sample with such a body: our headers and those of Ethernet, IP and UDP.
double wire_bytes(double body_bytes, std::size_t datagram_bytes, PlaceMark place);

/// Returns the cost of one sample under a plan.
double plan_cost(std::span<const PlanDestination> destinations, const BodyBytes& body_bytes,
                 const MulticastPlan& plan, const PlanLimits& limits);

/// The best plan; or the present one, if there is too little to gain.
MulticastPlan plan_multicast(std::span<const PlanDestination> destinations, const BodyBytes& body_bytes,
                             double samples_per_s, const MulticastPlan& present, const PlanLimits& limits);

}  // namespace sft::udp
