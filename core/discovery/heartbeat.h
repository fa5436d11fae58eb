// The heartbeat of a participant: a datagram that shows that its process lives, and contains digests of the
// records of that process. Cyclone would wake a thread for each datagram. So heartbeats use a separate
// socket, and wake no thread: they wait in the socket until Discovery::look_after() reads them.
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <span>

#include "core/discovery/records.h"

namespace sft::core {

/// Its numbers are written with the lowest octet first.
///
/// | octets | what |
/// |---|---|
/// | 0-2 | `SHB` |
/// | 3 | the version of the control protocol |
/// | 4-19 | the GUID of the participant |
/// | 20-27 | the process |
/// | 28-35 | the digest of its records about writers (records.h) |
/// | 36-43 | the digest of its records about readers |
struct Heartbeat {
  ParticipantGuid participant{};
  ProcessId process = 0;
  PerRole<std::uint64_t> digests{};
  friend bool operator==(const Heartbeat&, const Heartbeat&) = default;
};

inline constexpr std::size_t heartbeat_bytes = 44;
using HeartbeatDatagram = std::array<std::byte, heartbeat_bytes>;

HeartbeatDatagram encode(const Heartbeat& heartbeat);
/// Returns nothing if the datagram is not a heartbeat of this version.
std::optional<Heartbeat> decode_heartbeat(std::span<const std::byte> datagram);

}  // namespace sft::core
