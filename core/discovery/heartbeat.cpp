#include "core/discovery/heartbeat.h"

#include <bit>
#include <cstring>
#include <type_traits>

namespace sft::core {

namespace {

static_assert(std::endian::native == std::endian::little &&
                  std::has_unique_object_representations_v<Heartbeat>,
              "heartbeats are copied as they are");

/// Returns the octets before the GUID: the magic number and the version.
std::array<std::byte, 4> heartbeat_head() {
  return {std::byte{'S'}, std::byte{'H'}, std::byte{'B'}, static_cast<std::byte>(control_protocol_version())};
}

}  // namespace

HeartbeatDatagram encode(const Heartbeat& heartbeat) {
  HeartbeatDatagram datagram{};
  const auto head = heartbeat_head();
  std::memcpy(datagram.data(), head.data(), head.size());
  std::memcpy(datagram.data() + head.size(), &heartbeat, sizeof heartbeat);
  return datagram;
}

std::optional<Heartbeat> decode_heartbeat(std::span<const std::byte> datagram) {
  const auto head = heartbeat_head();
  if (datagram.size() != heartbeat_bytes || std::memcmp(datagram.data(), head.data(), head.size()) != 0)
    return std::nullopt;
  Heartbeat heartbeat;
  std::memcpy(&heartbeat, datagram.data() + head.size(), sizeof heartbeat);
  return heartbeat;
}

}  // namespace sft::core
