// A subscriber of the example in a process of its own: it reads its fields in the callback, and reports what
// came.
#pragma once

#include "tools/demo/roles/channel.h"
#include "tools/demo/roles/consumers.h"
#include "tools/demo/roles/role_node.h"

namespace sft::demo {

/// Serves orders until the channel closes. Defined for the five consumers of consumers.h.
template <class Consumer>
void run_subscriber(const NodePlan& plan, bool is_recorded, Channel& channel);

}  // namespace sft::demo
