// Sends answers: acks to the writers that are read reliably, and reports to all senders that request them.
// All answers leave through the receiving socket. So a sender that requests many answers uses up neither
// descriptors nor memory.
#pragma once

#include <memory>
#include <span>

#include "udp_transport/send/send_side.h"
#include "udp_transport/wire/datagram.h"

namespace sft::udp {

/// All functions must be called by the receiving thread.
class AnswerSender {
 public:
  explicit AnswerSender(std::shared_ptr<SendSide> side) : side_(std::move(side)) {}

  /// Sends the answer if it can be sent at once, and otherwise drops it. A later answer replaces a dropped
  /// one.
  void send(const SocketAddress& to, const Ack& ack);
  void send(const SocketAddress& to, const FlowReport& report);
  void send(const SocketAddress& to, const GroupReport& report);

 private:
  const std::shared_ptr<SendSide> side_;
};

}  // namespace sft::udp
