#include "core/discovery/pulse.h"

#include <bit>
#include <cstring>

namespace sft::core {

namespace {

static_assert(std::endian::native == std::endian::little, "numbers are copied as they are");

constexpr std::size_t version_at = 2, full_signs_at = 3, writers_at = 4, readers_at = 7, participant_at = 10,
                      node_at = 14, digest_bytes = 3;

PulseDatagram blank() {
  return {std::byte{'S'}, std::byte{'P'}, static_cast<std::byte>(control_protocol_version())};
}

}  // namespace

PulseDatagram encode(const Pulse& pulse) {
  PulseDatagram datagram = blank();
  const auto put = [&](std::size_t at, const auto& number, std::size_t bytes) {
    std::memcpy(datagram.data() + at, &number, bytes);
  };
  put(full_signs_at, pulse.full_signs, sizeof pulse.full_signs);
  put(writers_at, pulse.digest_of_writers, digest_bytes);
  put(readers_at, pulse.digest_of_readers, digest_bytes);
  put(participant_at, pulse.participant, sizeof pulse.participant);
  put(node_at, pulse.node, sizeof pulse.node);
  return datagram;
}

std::optional<Pulse> decode_pulse(std::span<const std::byte> datagram) {
  if (datagram.size() != pulse_bytes || std::memcmp(datagram.data(), blank().data(), full_signs_at) != 0)
    return std::nullopt;
  Pulse pulse;
  const auto get = [&](std::size_t at, auto& number, std::size_t bytes) {
    std::memcpy(&number, datagram.data() + at, bytes);
  };
  get(full_signs_at, pulse.full_signs, sizeof pulse.full_signs);
  get(writers_at, pulse.digest_of_writers, digest_bytes);
  get(readers_at, pulse.digest_of_readers, digest_bytes);
  get(participant_at, pulse.participant, sizeof pulse.participant);
  get(node_at, pulse.node, sizeof pulse.node);
  return pulse;
}

}  // namespace sft::core
