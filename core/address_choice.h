// Which of a reader's addresses a publisher sends to, where a host has several.
#pragma once

#include <cstdint>
#include <span>

#include "core/transport.h"

namespace sft::core {

/// The first that is in a network which we are in, too, by an interface of our own; else the first: routes
/// may lead there. An address that we have ourselves is another host's only by name (bridges of containers
/// have the same everywhere), so it comes last. REQUIRES: there is one.
const UdpAddress& choose_address(std::span<const UdpAddress> of_reader, std::span<const Link> ours);

}  // namespace sft::core
