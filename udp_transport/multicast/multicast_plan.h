// Decides which readers of a writer are sent one copy together, by the cost model of multicast.md. It is
// pure: sizes go in, a partition comes out.
#pragma once

#include <cstddef>
#include <span>

#include "udp_transport/multicast/plan_cost.h"

namespace sft::udp {

/// A plan that is good; or the present one with those in it who came anew, if there is too little to gain by
/// changing more.
MulticastPlan plan_multicast(std::span<const PlanDestination> destinations, const BodyBytes& body_bytes,
                             double samples_per_s, const MulticastPlan& present, const PlanLimits& limits);

}  // namespace sft::udp
