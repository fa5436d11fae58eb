// Chooses the address of a reader that a publisher sends to, where the reader's host has several.
#pragma once

#include <cstdint>
#include <span>

#include "core/seam/transport.h"

namespace sft::core {

/// The first of the best: those in a network that we are in, too, by an interface of our own with a carrier,
/// by wire at both ends before by radio; then those that routes may lead to, of a family that we have; then
/// link-local ones, since
/// these look near everywhere, completed by an interface of ours. Behind an interface without carrier there
/// is none but by name, and an address that we have ourselves is another host's only by name, too (bridges of
/// containers have the same everywhere): these come last. REQUIRES: there is one.
UdpAddress choose_address(std::span<const UdpAddress> of_reader, std::span<const Link> ours);

}  // namespace sft::core
