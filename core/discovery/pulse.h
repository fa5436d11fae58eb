// A pulse: a sign of life that tells nothing else, as a small datagram of its own beside Cyclone's. Cyclone
// wakes a thread for each datagram. Pulses wake nobody: they wait until discovery is looked after. Who gives
// them, and what they count for, is in discovery.md.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "core/control/control.h"

namespace sft::core {

/// Its numbers are written with the lowest octet first.
///
/// | octets | what |
/// |---|---|
/// | 0-1 | `SP` |
/// | 2 | the version of the control protocol |
/// | 3 | how many full signs of life the participant has given, modulo 256 |
/// | 4-6 | the digest of writers (control_digest.h) |
/// | 7-9 | the digest of readers |
/// | 10-13 | the tag of the participant (participants.h) |
/// | 14-21 | the node |
struct Pulse {
  NodeId node = 0;
  std::uint32_t participant = 0;  ///< the tag of who speaks for the node on that link
  std::uint32_t digest_of_writers = 0;
  std::uint32_t digest_of_readers = 0;
  std::uint8_t full_signs = 0;
  friend bool operator==(const Pulse&, const Pulse&) = default;
};

inline constexpr std::size_t pulse_bytes = 22;
using PulseDatagram = std::array<std::byte, pulse_bytes>;

PulseDatagram encode(const Pulse& pulse);
/// Nothing if the datagram is anything else, or of another version.
std::optional<Pulse> decode_pulse(std::span<const std::byte> datagram);

}  // namespace sft::core
