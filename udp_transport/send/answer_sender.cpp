#include "udp_transport/send/answer_sender.h"

#include <array>

namespace sft::udp {

void AnswerSender::send(const SocketAddress& to, const Ack& ack) {
  std::array<std::byte, datagram_bytes_min> bytes;
  encode(ack, bytes.data());
  side_->sender.send_to(to, std::span(bytes).first(ack.bytes()));
}

void AnswerSender::send(const SocketAddress& to, const FlowReport& report) {
  std::array<std::byte, report_bytes> bytes;
  encode(report, bytes.data());
  side_->sender.send_to(to, bytes);
}

void AnswerSender::send(const SocketAddress& to, const GroupReport& report) {
  std::array<std::byte, group_report_bytes> bytes;
  encode(report, bytes.data());
  side_->sender.send_to(to, bytes);
}

}  // namespace sft::udp
