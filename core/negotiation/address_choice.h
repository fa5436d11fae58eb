// Chooses the address of a reader that a publisher sends to, where the reader's host has several.
#pragma once

#include <cstdint>
#include <span>

#include "core/seam/transport.h"

namespace sft::core {

/// Returns the first of the best addresses. The best ones are in a network that this host is in, too, by an
/// interface of its own with a carrier; a wire at both ends is better than radio. Next come addresses that
/// routes may lead to, of a family that this host has. Then come link-local addresses, since these look near
/// everywhere; an interface of this host completes them. Last come addresses behind an interface without a
/// carrier, and addresses that this host has as well: datagrams to these stay here (bridges of containers
/// have the same addresses on all hosts). REQUIRES: there is one.
UdpAddress choose_address(std::span<const UdpAddress> of_reader, std::span<const Link> ours);

}  // namespace sft::core
