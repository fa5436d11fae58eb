#include "udp_transport/receive/demultiplexer.h"

#include <new>
#include <optional>
#include <utility>
#include <variant>

namespace sft::udp {

Demultiplexer::Demultiplexer(Handlers handlers, Reassembly& reassembly, std::size_t receive_buffer_bytes)
    : handlers_(std::move(handlers)), reassembly_(reassembly), shares_(receive_buffer_bytes) {}

Arrival Demultiplexer::accept(std::span<const std::byte> bytes, const SocketAddress& from,
                              ArrivalTime now) noexcept try {
  AnyDatagram datagram = decode(bytes);
  const Envelope envelope{from, now, bytes.size()};
  Arrival arrival = std::visit([&](auto& d) { return take(d, envelope); }, datagram);
  if (!arrival.is_empty() && from.ip != last_from_)
    reassembly_.came_from(arrival.stream, last_from_ = from.ip);
  return arrival;
} catch (const std::bad_alloc&) {
  return {};
}

/// Counts a malformed datagram as arrived, since the sender's flow marks count all its datagrams of samples
/// and heartbeats. A malformed datagram of a kind that flow marks do not count is not counted as arrived.
Arrival Demultiplexer::take(Malformed& d, const Envelope& envelope) {
  const bool is_counted =
      !d.kind || (!is_answer(*d.kind) && *d.kind != DatagramKind::mark &&
                  *d.kind != DatagramKind::group_offer && *d.kind != DatagramKind::group_probe);
  if (is_counted) shares_.count(envelope.from);
  reassembly_.refuse(d);
  return {};
}

/// Answers the flow mark at once with a report, because all datagrams that were sent before the mark have
/// left the socket.
Arrival Demultiplexer::take(FlowMark& d, const Envelope& envelope) {
  const std::optional<SocketAddress> to = reassembly_.report_address(envelope.from.ip, d.port);
  if (to) {
    FlowReport report = shares_.answer(d, envelope.from, envelope.now.steady);
    report.longest = longest_.answer(envelope.from.ip, envelope.bytes, envelope.now.steady);
    handlers_.send_report(*to, report);
  } else {
    ++unknown_marks_;
  }
  return {};
}

Arrival Demultiplexer::take(GroupOffer& d, const Envelope& envelope) {
  const std::optional<Reassembly::Joining> joining = reassembly_.accept(d, envelope);
  if (!joining) return {};
  handlers_.keep_groups(reassembly_.groups());
  if (joining->group != 0) handlers_.join_group(joining->group, envelope.from, joining->anew);
  return {};
}

Arrival Demultiplexer::take(GroupProbe& d, const Envelope& envelope) {
  reassembly_.accept(d, envelope);
  return {};
}

Arrival Demultiplexer::take(Answer& d, const Envelope& envelope) {
  handlers_.hear_answer(d, envelope.from, envelope.now.steady);
  return {};
}

}  // namespace sft::udp
