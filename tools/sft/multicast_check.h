// Checks multicast on the interfaces of this host, as far as this is possible with one host.
#pragma once

#include <string>
#include <vector>

#include "tools/sft/finding.h"
#include "tools/terminal/stop.h"

namespace sft::tool {

/// Sends a datagram to a group by each interface and waits until the same interface receives it. The check
/// cannot see whether a switch forwards the datagram to other hosts. `in_use` names the interfaces to
/// check; if it is empty, all interfaces are checked.
std::vector<Finding> check_multicast(const std::vector<std::string>& in_use, Stop& stop);

}  // namespace sft::tool
