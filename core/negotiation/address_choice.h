// Chooses the address to which a publisher sends, if the reader's host has several.
#pragma once

#include <cstdint>
#include <span>

#include "core/seam/transport.h"

namespace sft::core {

/// Returns the first of the best addresses. The best ones are in a network to which this host is also
/// connected, by an interface with a carrier; wired interfaces at both ends are better than wireless ones.
/// Next come addresses that may be reached by routes, of an address family that this host has. Then come
/// link-local addresses, which seem to be near on every host; their scope becomes that of an interface of
/// this host. Last come addresses of interfaces without a carrier, and addresses that this host has as
/// well. Datagrams to an address of this host would not leave the host (bridges of containers have the same
/// addresses on all hosts). REQUIRES: `of_reader` is not empty.
UdpAddress choose_address(std::span<const UdpAddress> of_reader, std::span<const Link> ours);

}  // namespace sft::core
