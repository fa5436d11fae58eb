// Passes datagrams to a reassembly as the demultiplexer does.
#pragma once

#include <cstddef>
#include <span>
#include <variant>

#include "udp_transport/receive/reassembly.h"

namespace sft::udp::test {

/// Returns the arrival that the datagram causes. Flow marks and answers contain no samples, so the arrival
/// is empty for them.
inline Arrival accept(Reassembly& reassembly, std::span<const std::byte> bytes, ArrivalTime now,
                      const SocketAddress& from = {}) {
  AnyDatagram datagram = decode(bytes);
  const Envelope envelope{from, now, bytes.size()};
  if (auto* sample = std::get_if<Datagram>(&datagram)) return reassembly.accept(*sample, envelope);
  if (auto* following = std::get_if<Following>(&datagram)) return reassembly.accept(*following, envelope);
  if (auto* heartbeat = std::get_if<Heartbeat>(&datagram)) return reassembly.accept(*heartbeat, envelope);
  if (auto* offer = std::get_if<GroupOffer>(&datagram)) reassembly.accept(*offer, envelope);
  if (auto* malformed = std::get_if<Malformed>(&datagram)) reassembly.refuse(*malformed);
  return {};
}

}  // namespace sft::udp::test
