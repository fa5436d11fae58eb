// The addresses to which acks are sent to one writer, and the number of bytes that these acks may have. It is
// not certain that the writer is there. So the limit is three times the number of bytes that came in the
// writer's name, as in QUIC before an address is validated (RFC 9000, section 8.1), and an attacker gains
// little by making this process send answers to another host. The class uses no clock, thread or I/O.
#pragma once

#include <algorithm>
#include <cstddef>
#include <functional>
#include <optional>

#include "udp_transport/io/datagram_io.h"
#include "udp_transport/wire/datagram.h"

namespace sft::udp {

using SendAck = std::function<void(const SocketAddress&, const Ack&)>;

class AnswerPath {
 public:
  /// Notes that a datagram of the writer came.
  void received(std::size_t bytes) { allowed_ = std::min(allowed_ + factor * bytes, allowed_max); }
  /// Notes that a heartbeat requests acks at this address. Since a single heartbeat may be wrong, acks are
  /// sent to the former address, too, until the next heartbeat.
  void turn_to(const SocketAddress& address) {
    const bool confirmed = !confirmed_ || unconfirmed_ == address;
    if (confirmed) confirmed_ = address;
    unconfirmed_.reset();
    if (confirmed_ != address) unconfirmed_ = address;
  }
  void close() {
    confirmed_.reset();
    unconfirmed_.reset();
  }
  bool is_known() const { return confirmed_.has_value(); }

  /// Returns true if an ack of that length may be sent to each address.
  bool covers(std::size_t ack_bytes) const { return copies() * ack_bytes <= allowed_; }
  /// Returns the number of missing parts that an ack to each address may request.
  std::size_t parts_covered() const {
    const std::size_t bytes = allowed_ / copies();
    return bytes < ack_header_bytes ? 0 : (bytes - ack_header_bytes) / missing_bytes;
  }
  /// REQUIRES: is_known(). Sends the ack to each address, unless all copies together would have too many
  /// bytes.
  void send(const Ack& ack, const SendAck& send) {
    if (!covers(ack.bytes())) return;
    allowed_ -= copies() * ack.bytes();
    send(*confirmed_, ack);
    if (unconfirmed_) send(*unconfirmed_, ack);
  }

 private:
  static constexpr std::size_t factor = 3;
  static constexpr std::size_t allowed_max = std::size_t{1} << 20;

  std::size_t copies() const { return unconfirmed_ ? 2 : 1; }

  std::optional<SocketAddress> confirmed_;
  std::optional<SocketAddress> unconfirmed_;  ///< an address that only one heartbeat has named so far
  std::size_t allowed_ = 0;                   ///< number of bytes that acks may have
};

}  // namespace sft::udp
