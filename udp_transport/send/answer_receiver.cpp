#include "udp_transport/send/answer_receiver.h"

#include <array>

#include "udp_transport/wire/datagram.h"

namespace sft::udp {

namespace {
// The number per call is limited, because attackers may send more datagrams than can be handled.
constexpr std::size_t answers_at_once = 64;
}  // namespace

void AnswerReceiver::listen() {
  std::array<std::byte, datagram_bytes_min> answer;
  for (std::size_t i = 0; i < answers_at_once; ++i) {
    const DatagramSender::Answer came = io_.take_answer(answer);
    if (came.bytes == 0) return;
    const std::span<const std::byte> datagram = std::span(answer).first(came.bytes);
    if (hear_ && hear_(datagram, came.from, std::chrono::steady_clock::now()) != Wake::none) round_.at_once();
  }
}

}  // namespace sft::udp
