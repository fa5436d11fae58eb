// Asks the system for the addresses of a host by its name.
#pragma once

#include <string>
#include <vector>

#include "core/platform/ip_address.h"
#include "sft/result.h"

namespace sft::core {

enum class IpFamily { ipv4, ipv6 };

/// Addresses in their order, each once. The error says why there are none, in the words of the system. May
/// take minutes where a name server is silent: not to be called on a thread that has anything else to do.
Result<std::vector<IpAddress>> addresses_of_host(const std::string& name, IpFamily family);

}  // namespace sft::core
