// Decides by the cost model of multicast.md which readers of a writer share one copy of its samples. Uses no
// clock, thread or I/O.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "udp_transport/multicast/plan_cost.h"

namespace sft::udp {

/// Returns a plan of low cost. If it would be only a little cheaper than the present plan, the result is the
/// present plan with new destinations added.
MulticastPlan plan_multicast(std::span<const PlanDestination> destinations, const BodyBytes& body_bytes,
                             double samples_per_s, const MulticastPlan& present, const PlanLimits& limits);

/// Returns the places of the groups in the next plan: unique small numbers, from which the groups' addresses
/// are computed. `places` are the places of the present groups. A group that stays keeps its place. A group
/// whose members have changed keeps its place, too, if possible.
std::vector<std::size_t> keep_places(const MulticastPlan& present, std::span<const std::size_t> places,
                                     const MulticastPlan& next);

}  // namespace sft::udp
