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
  std::string interfaces_in_use{};  ///< in the library's words; empty where no node can be opened
};
NodeFindings check_node(const CommonOptions& common, Stop& stop, Output& output);

}  // namespace sft::tool
