// Decodes each datagram once and passes it to the class that handles its kind. Uses no clock, thread or I/O
// of its own.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>

#include "core/platform/ip_address.h"
#include "udp_transport/flow/longest_arrivals.h"
#include "udp_transport/flow/receive_shares.h"
#include "udp_transport/io/datagram_io.h"
#include "udp_transport/receive/reassembly.h"
#include "udp_transport/wire/datagram.h"

namespace sft::udp {

/// All functions must be called by the receiving thread.
class Demultiplexer {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// The functions that accept() calls for datagrams that are not part of a sample.
  struct Handlers {
    /// Passes an answer (an ack or a report) to the sending half of the transport.
    std::function<void(const Answer&, const SocketAddress& from, Time)> hear_answer;
    /// Sends a report, which answers a flow mark.
    std::function<void(const SocketAddress& to, const FlowReport&)> send_report;
    /// Leaves all multicast groups except `groups`, which are IPv4 addresses.
    std::function<void(std::span<const std::uint32_t> groups)> keep_groups;
    /// Joins a multicast group on the link by which `towards` is reached. If `anew` is true and the group
    /// was joined before, leaves it first.
    std::function<void(std::uint32_t group, const SocketAddress& towards, bool anew)> join_group;
  };

  /// `reassembly` must outlive this object. `receive_buffer_bytes` is the size of the socket's receive
  /// buffer, which is divided among all senders to the socket.
  Demultiplexer(Handlers handlers, Reassembly& reassembly, std::size_t receive_buffer_bytes);

  /// Processes a datagram. Returns the samples that it completes for readers. If memory for the datagram
  /// cannot be allocated, it counts as lost.
  Arrival accept(std::span<const std::byte> bytes, const SocketAddress& from, ArrivalTime now) noexcept;

  /// Returns the number of flow marks that were not answered, because no writer of the process that sent
  /// them is read here.
  std::uint64_t unknown_marks() const { return unknown_marks_; }
  /// Returns the number of processes that share the receive buffer.
  std::size_t senders() const { return shares_.senders(); }

 private:
  Arrival take(Malformed& d, const Envelope& envelope);
  /// Processes a datagram of a sample, or a heartbeat, and counts it. Flow marks contain the number of such
  /// datagrams that were sent.
  template <class FromWriter>
  Arrival take(FromWriter& d, const Envelope& envelope) {
    shares_.count(envelope.from);
    longest_.note(envelope.from.ip, envelope.bytes, envelope.now.steady);
    return reassembly_.accept(d, envelope);
  }
  Arrival take(FlowMark& d, const Envelope& envelope);
  Arrival take(GroupOffer& d, const Envelope& envelope);
  Arrival take(GroupProbe& d, const Envelope& envelope);
  Arrival take(Answer& d, const Envelope& envelope);

  const Handlers handlers_;
  Reassembly& reassembly_;
  ReceiveShares shares_;
  LongestArrivals longest_;
  core::IpAddress last_from_;  ///< the address from which the latest sample came
  std::uint64_t unknown_marks_ = 0;
};

}  // namespace sft::udp
