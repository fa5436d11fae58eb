// The fewest bytes on the wire that can carry a message.
#pragma once

#include <cstddef>

namespace sft::bench::paper {

/// The bytes of frames that carry a message of so many bytes of CDR and no header but those of Ethernet, IPv4
/// and UDP. All frames but the last one are full at an MTU of 1500. An empty message takes one frame.
std::size_t least_bytes(std::size_t cdr_bytes);

}  // namespace sft::bench::paper
