// What the doctor finds by opening a node: what the library itself says of this host.
#pragma once

#include <string>
#include <vector>

#include "tools/sft/common_options.h"
#include "tools/sft/finding.h"
#include "tools/sft/output.h"
#include "tools/sft/stop.h"

namespace sft::tool {

struct NodeFindings {
  std::vector<Finding> findings;
  /// Names; empty where no node can be opened, or where the library does not know.
  std::vector<std::string> interfaces_in_use{};
};
NodeFindings check_node(const CommonOptions& common, Stop& stop, Output& output);

}  // namespace sft::tool
