// The LiDAR: publishes the clouds of a source at a rate, on order.
#pragma once

#include <memory>

#include "examples/demo/channel.h"
#include "examples/demo/cloud_source.h"
#include "examples/demo/role_node.h"

namespace sft::demo {

/// Serves orders until the channel closes.
void run_publisher(const NodePlan& plan, CloudSource& source, Channel& channel);

}  // namespace sft::demo
