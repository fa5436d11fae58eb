// Decides which readers of a writer are sent one copy together, by the cost model of multicast.md. It is
// pure: sizes go in, a partition comes out.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "udp_transport/multicast/plan_cost.h"

namespace sft::udp {

/// A plan that is good; or the present one with those in it who came anew, if there is too little to gain by
/// changing more.
MulticastPlan plan_multicast(std::span<const PlanDestination> destinations, const BodyBytes& body_bytes,
                             double samples_per_s, const MulticastPlan& present, const PlanLimits& limits);

/// Returns the places of the groups in the next plan, no two alike: a group is sent to an address that goes
/// by its place. `places` are those of the present groups, which are left where they are. A group whose
/// members have changed stays there, too, if it can.
std::vector<std::size_t> keep_places(const MulticastPlan& present, std::span<const std::size_t> places,
                                     const MulticastPlan& next);

}  // namespace sft::udp
