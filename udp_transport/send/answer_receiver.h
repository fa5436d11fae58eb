// Hears what comes back to the port for answers, on the sending thread.
#pragma once

#include <chrono>
#include <cstddef>
#include <functional>
#include <span>
#include <utility>

#include "udp_transport/io/datagram_io.h"
#include "udp_transport/outgoing/wake.h"
#include "udp_transport/send/next_round.h"

namespace sft::udp {

class AnswerReceiver {
 public:
  using Hear = std::function<Wake(std::span<const std::byte> datagram, const SocketAddress& from,
                                  std::chrono::steady_clock::time_point)>;
  /// Both outlive this object.
  AnswerReceiver(DatagramSender& io, NextRound& round) : io_(io), round_(round) {}

  /// Called before the sending thread begins. An empty function hears nothing.
  void tell(Hear hear) { hear_ = std::move(hear); }
  /// Hears what has come, without waiting. The sending thread calls this between the calls for a large
  /// sample, too: the sample goes on without waiting as long as answers come in time.
  void listen();

 private:
  DatagramSender& io_;
  NextRound& round_;
  Hear hear_;
};

}  // namespace sft::udp
