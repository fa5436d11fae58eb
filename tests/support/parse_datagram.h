// Parses datagrams of one kind, for tests that know which kind they expect.
#pragma once

#include <concepts>
#include <cstddef>
#include <optional>
#include <span>
#include <variant>
#include <vector>

#include "udp_transport/wire/datagram.h"

namespace sft::udp {

/// Returns the datagram, or nothing if the bytes are no valid datagram of that kind.
template <class Kind>
std::optional<Kind> parse_as(std::span<const std::byte> bytes) {
  const auto take = []<class Found>(const Found& found) {
    if constexpr (std::same_as<Found, Kind>) return std::optional(found);
    return std::optional<Kind>();
  };
  const AnyDatagram any = decode(bytes);
  const Answer* answer = std::get_if<Answer>(&any);
  return answer == nullptr ? std::visit(take, any) : std::visit(take, *answer);
}

/// Returns the datagram, or nothing if the bytes are no valid datagram of a sample. A following datagram has
/// only the label, the offset and the payload.
inline std::optional<Datagram> parse(std::span<const std::byte> bytes) {
  const auto following = parse_as<Following>(bytes);
  if (!following) return parse_as<Datagram>(bytes);
  Datagram d;
  d.kind = DatagramKind::following;
  d.first.label = following->label;
  d.offset = following->offset;
  d.payload = following->payload;
  return d;
}

/// Returns the kind that the first byte gives, although the rest may be malformed. Returns nothing if the
/// bytes are no datagram of this version.
inline std::optional<DatagramKind> kind_of(std::span<const std::byte> bytes) {
  const AnyDatagram any = decode(bytes);
  if (const auto* malformed = std::get_if<Malformed>(&any)) return malformed->kind;
  return static_cast<DatagramKind>(std::to_integer<unsigned>(bytes[0]) & 0xf);
}

namespace test {

/// Returns the bytes as numbers. Unlike bytes, numbers are legible when a failed comparison prints them.
inline std::vector<unsigned> numbers_of(std::span<const std::byte> bytes) {
  std::vector<unsigned> numbers;
  for (const std::byte one : bytes) numbers.push_back(std::to_integer<unsigned>(one));
  return numbers;
}

}  // namespace test

}  // namespace sft::udp
