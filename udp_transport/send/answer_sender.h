// Sends acks to the writers that are heard reliably, and reports to all who ask for them. All of them leave
// through one socket that is there anyway: whoever asks costs neither a descriptor nor memory. Of the
// receiving thread.
#pragma once

#include <memory>
#include <span>

#include "udp_transport/send/send_side.h"
#include "udp_transport/wire/datagram.h"

namespace sft::udp {

class AckSender {
 public:
  explicit AckSender(std::shared_ptr<SendSide> side) : side_(std::move(side)) {}

  /// Now or not at all: where one does not leave, another will follow.
  void send(const SocketAddress& to, const Ack& ack);
  void send(const SocketAddress& to, const FlowReport& report);
  void send(const SocketAddress& to, const GroupReport& report);

 private:
  const std::shared_ptr<SendSide> side_;
};

}  // namespace sft::udp
