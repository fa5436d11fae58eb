// The roles of the example, each in a process of its own. They serve orders of the demo until the channel
// closes.
#pragma once

#include "tools/demo/roles/channel.h"
#include "tools/demo/roles/role_node.h"

namespace sft::demo {

/// The lidar publishes clouds at a rate when the demo orders it.
void run_publisher(const NodePlan& plan, Channel& channel);

/// Runs a subscriber whose callback reads the fields that `Consumer` needs, and reports through `channel`
/// what it received. Defined for the five consumers of consumers.h.
template <class Consumer>
void run_subscriber(const NodePlan& plan, bool is_recorded, Channel& channel);

}  // namespace sft::demo
