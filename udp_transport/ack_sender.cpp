#include "udp_transport/ack_sender.h"

#include <array>

namespace sft::udp {

void AckSender::send(const SocketAddress& to, const Ack& ack) {
  std::array<std::byte, datagram_bytes_min> bytes;
  encode(ack, bytes.data());
  send(to, std::span(bytes).first(ack.bytes()));
}

void AckSender::send(const SocketAddress& to, const FlowReport& report) {
  std::array<std::byte, report_bytes> bytes;
  encode(report, bytes.data());
  send(to, bytes);
}

void AckSender::send(const SocketAddress& to, const GroupReport& report) {
  std::array<std::byte, group_report_bytes> bytes;
  encode(report, bytes.data());
  send(to, bytes);
}

void AckSender::send(const SocketAddress& to, std::span<const std::byte> bytes) {
  if (known_.size() >= known_max && !known_.contains(to)) known_.clear();
  std::shared_ptr<Destination>& destination = known_[to];
  if (destination == nullptr) destination = side_->destinations.find({.ip = to.ip, .port = to.port});
  const iovec part{const_cast<std::byte*>(bytes.data()), bytes.size()};  // it is only read
  const OutgoingBatch batch{{&part, 1}, 0};
  destination->note(destination->connection().try_send({&batch, 1}).outcome);
}

}  // namespace sft::udp
