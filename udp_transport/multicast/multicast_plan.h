// Decides which readers of a writer are sent one copy together, by the cost model of multicast.md. Uses no
// clock, thread or I/O.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "udp_transport/multicast/plan_cost.h"

namespace sft::udp {

/// Returns a good plan. If there is too little to gain by changing more, this is the present plan, to which
/// new destinations are added.
MulticastPlan plan_multicast(std::span<const PlanDestination> destinations, const BodyBytes& body_bytes,
                             double samples_per_s, const MulticastPlan& present, const PlanLimits& limits);

/// Returns the places of the groups in the next plan, all of them different. The address of a group follows
/// from its place. `places` are those of the present groups. A group that stays keeps its place, and so
/// does one whose members have changed, if it can.
std::vector<std::size_t> keep_places(const MulticastPlan& present, std::span<const std::size_t> places,
                                     const MulticastPlan& next);

}  // namespace sft::udp
