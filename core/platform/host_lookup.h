// Looks up the addresses of a host by its name, with the functions of the system.
#pragma once

#include <string>
#include <vector>

#include "core/platform/ip_address.h"
#include "sft/result.h"

namespace sft::core {

enum class IpFamily { ipv4, ipv6 };

/// Returns the addresses in ascending order, each once. If there are none, the error contains the system's
/// reason. The call may take minutes if a name server does not answer, so it needs a thread without other
/// work.
Result<std::vector<IpAddress>> addresses_of_host(const std::string& name, IpFamily family);

}  // namespace sft::core
