// The LiDAR publishes the clouds of a source at a rate when the demo orders it.
#pragma once

#include <memory>

#include "tools/demo/clouds/cloud_source.h"
#include "tools/demo/roles/channel.h"
#include "tools/demo/roles/role_node.h"

namespace sft::demo {

/// Serves orders until the channel closes.
void run_publisher(const NodePlan& plan, CloudSource& source, Channel& channel);

}  // namespace sft::demo
