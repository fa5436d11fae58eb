// The addresses to which acks are sent to one writer, and the number of bytes that these acks may have. The
// class uses no clock, thread or I/O.
#pragma once

#include <cstddef>
#include <functional>
#include <optional>

#include "udp_transport/io/datagram_io.h"
#include "udp_transport/receive/answer_credit.h"
#include "udp_transport/wire/datagram.h"

namespace sft::udp {

using SendAck = std::function<void(const SocketAddress&, const Ack&)>;

class AnswerPath {
 public:
  /// Notes that a datagram of the writer came. It allows answers of a few times as many bytes
  /// (AnswerCredit).
  void received(std::size_t bytes) { credit_.received(bytes); }
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

  /// Returns true if the allowed bytes suffice to send an ack of that length to each address.
  bool covers(std::size_t ack_bytes) const { return credit_.covers(copies() * ack_bytes); }
  /// Returns the number of missing parts that an ack to each address may request within the allowed bytes.
  std::size_t parts_covered() const {
    const std::size_t bytes = credit_.left() / copies();
    return bytes < ack_header_bytes ? 0 : (bytes - ack_header_bytes) / missing_bytes;
  }
  /// Sends the ack to each address. Sends nothing if all copies together would have too many bytes.
  void send(const Ack& ack, const SendAck& send) {
    if (!covers(ack.bytes())) return;
    credit_.spend(copies() * ack.bytes());
    send(*confirmed_, ack);
    if (unconfirmed_) send(*unconfirmed_, ack);
  }

 private:
  std::size_t copies() const { return unconfirmed_ ? 2 : 1; }

  std::optional<SocketAddress> confirmed_;
  std::optional<SocketAddress> unconfirmed_;  ///< an address that only one heartbeat has named so far
  AnswerCredit credit_;
};

}  // namespace sft::udp
