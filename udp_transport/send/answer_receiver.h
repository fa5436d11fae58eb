// Reads the datagrams from the socket for answers (acks and reports), on the sending thread.
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
  /// Both arguments must outlive this object.
  AnswerReceiver(DatagramSender& io, NextRound& round) : io_(io), round_(round) {}

  /// Sets the function that handles answers. If it is empty, answers are ignored. Must be called before the
  /// sending thread begins.
  void set_handler(Hear hear) { hear_ = std::move(hear); }
  /// Reads and handles the answers that have come, without waiting. The sending thread also calls this
  /// function between the system calls for a large sample. So the sample is sent without a pause if answers
  /// come in time.
  void listen();

 private:
  DatagramSender& io_;
  NextRound& round_;
  Hear hear_;
};

}  // namespace sft::udp
