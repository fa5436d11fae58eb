// Asks the system for the addresses of a host by its name.
#pragma once

#include <string>
#include <vector>

#include "core/platform/ip_address.h"
#include "sft/result.h"

namespace sft::core {

enum class IpFamily { ipv4, ipv6 };

/// Returns the addresses in ascending order, each once. The error contains the system's reason why there are
/// none. The call may take minutes if a name server does not answer, so it needs a thread that has nothing
/// else to do.
Result<std::vector<IpAddress>> addresses_of_host(const std::string& name, IpFamily family);

}  // namespace sft::core
