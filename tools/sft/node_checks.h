// The checks of `sft doctor` that open a node and report the state of this host according to the library.
#pragma once

#include <sft/domain.h>
#include <string>
#include <vector>

#include "tools/sft/common_options.h"
#include "tools/sft/finding.h"
#include "tools/sft/output.h"
#include "tools/terminal/stop.h"

namespace sft::tool {

struct NodeFindings {
  std::vector<Finding> findings;
  /// The names of the interfaces; empty if no node can be opened, or if the library does not report the
  /// names.
  std::vector<std::string> interfaces_in_use{};
  DomainSnapshot domain{};  ///< the processes and endpoints that the node has found
};
NodeFindings check_node(const CommonOptions& common, Stop& stop, Output& output);

}  // namespace sft::tool
