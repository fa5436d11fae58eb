#include "core/discovery/heartbeat.h"

#include <bit>
#include <cstring>

namespace sft::core {

namespace {

static_assert(std::endian::native == std::endian::little, "numbers are copied as they are");

/// Returns the octets before the GUID: the magic number and the version.
std::array<std::byte, 4> heartbeat_head() {
  return {std::byte{'S'}, std::byte{'H'}, std::byte{'B'}, static_cast<std::byte>(control_protocol_version())};
}

/// Calls act(at, member) for each member, with its offset in the datagram.
template <class AnyHeartbeat, class Act>
void each_member(AnyHeartbeat& heartbeat, Act act) {
  act(4, heartbeat.participant);
  act(20, heartbeat.process);
  act(28, heartbeat.digests.writer);
  act(36, heartbeat.digests.reader);
}

}  // namespace

HeartbeatDatagram encode(const Heartbeat& heartbeat) {
  HeartbeatDatagram datagram{};
  const auto head = heartbeat_head();
  std::memcpy(datagram.data(), head.data(), head.size());
  each_member(heartbeat, [&](std::size_t at, const auto& member) {
    std::memcpy(datagram.data() + at, &member, sizeof member);
  });
  return datagram;
}

std::optional<Heartbeat> decode_heartbeat(std::span<const std::byte> datagram) {
  const auto head = heartbeat_head();
  if (datagram.size() != heartbeat_bytes || std::memcmp(datagram.data(), head.data(), head.size()) != 0)
    return std::nullopt;
  Heartbeat heartbeat;
  each_member(heartbeat, [&](std::size_t at, auto& member) {
    std::memcpy(&member, datagram.data() + at, sizeof member);
  });
  return heartbeat;
}

}  // namespace sft::core
