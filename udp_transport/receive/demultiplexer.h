// Decodes each datagram once and hands it to the class that handles it. Uses no clock, thread or I/O of its
// own.
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

/// All functions are called by the receiving thread.
class Demultiplexer {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// accept() calls these functions for datagrams that bring no samples.
  struct Handlers {
    /// Hands an answer to the sending half of the transport.
    std::function<void(const Answer&, const SocketAddress& from, Time)> hear_answer;
    /// Sends a report, which answers a mark.
    std::function<void(const SocketAddress& to, const FlowReport&)> send_report;
    /// Leaves all multicast groups except `groups`, which are IPv4 addresses.
    std::function<void(std::span<const std::uint32_t> groups)> keep_groups;
    /// Joins a group on the link towards that address. If `anew`, leaves the group first if it was joined
    /// before.
    std::function<void(std::uint32_t group, const SocketAddress& towards, bool anew)> join_group;
  };

  /// The reassembly must outlive the demultiplexer. All senders to the socket share `receive_buffer_bytes`.
  Demultiplexer(Handlers handlers, Reassembly& reassembly, std::size_t receive_buffer_bytes);

  /// Returns what the datagram brought for readers. If there is no memory for a datagram, it counts as
  /// lost.
  Arrival accept(std::span<const std::byte> bytes, const SocketAddress& from, ArrivalTime now) noexcept;

  /// Returns the number of marks from processes of which no writer is read here.
  std::uint64_t unknown_marks() const { return unknown_marks_; }
  /// Returns the number of processes that share the receive buffer.
  std::size_t senders() const { return shares_.senders(); }

 private:
  Arrival take(Malformed& d, const Envelope& envelope);
  /// Takes a sample's datagram or a heartbeat, and counts it. Marks contain the number of such datagrams
  /// sent.
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
  core::IpAddress last_from_;  ///< the address that the latest sample came from
  std::uint64_t unknown_marks_ = 0;
};

}  // namespace sft::udp
