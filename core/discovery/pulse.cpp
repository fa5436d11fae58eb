#include "core/discovery/pulse.h"

#include <bit>
#include <cstring>

namespace sft::core {

namespace {

static_assert(std::endian::native == std::endian::little, "numbers are copied as they are");

constexpr std::size_t magic_and_version_bytes = 3, digest_bytes = 3;

PulseDatagram blank() {
  return {std::byte{'S'}, std::byte{'P'}, static_cast<std::byte>(control_protocol_version())};
}

/// Calls act(at, number, bytes) for each number behind the version.
template <class AnyPulse, class Act>
void each_number(AnyPulse& pulse, Act act) {
  act(3, pulse.full_signs, sizeof pulse.full_signs);
  act(4, pulse.digest_of_writers, digest_bytes);
  act(7, pulse.digest_of_readers, digest_bytes);
  act(10, pulse.participant, sizeof pulse.participant);
  act(14, pulse.node, sizeof pulse.node);
}

}  // namespace

PulseDatagram encode(const Pulse& pulse) {
  PulseDatagram datagram = blank();
  each_number(pulse, [&](std::size_t at, const auto& number, std::size_t bytes) {
    std::memcpy(datagram.data() + at, &number, bytes);
  });
  return datagram;
}

std::optional<Pulse> decode_pulse(std::span<const std::byte> datagram) {
  if (datagram.size() != pulse_bytes ||
      std::memcmp(datagram.data(), blank().data(), magic_and_version_bytes) != 0)
    return std::nullopt;
  Pulse pulse;
  each_number(pulse, [&](std::size_t at, auto& number, std::size_t bytes) {
    std::memcpy(&number, datagram.data() + at, bytes);
  });
  return pulse;
}

}  // namespace sft::core
