// Decides by the cost model of multicast.md which readers of a writer share one copy. Uses no clock, thread
// or I/O.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "udp_transport/multicast/plan_cost.h"

namespace sft::udp {

/// Returns a good plan. If a better plan would gain too little, the result is the present plan, with new
/// destinations added.
MulticastPlan plan_multicast(std::span<const PlanDestination> destinations, const BodyBytes& body_bytes,
                             double samples_per_s, const MulticastPlan& present, const PlanLimits& limits);

/// Returns the places of the groups in the next plan, all of them different. `places` are those of the
/// present groups. The address of a group follows from its place. A group that stays keeps its place. A
/// group whose members have changed keeps it, too, if possible.
std::vector<std::size_t> keep_places(const MulticastPlan& present, std::span<const std::size_t> places,
                                     const MulticastPlan& next);

}  // namespace sft::udp
