#include "udp_transport/ack_sender.h"

#include <array>

namespace sft::udp {

void AckSender::send(const SocketAddress& to, const Ack& ack) {
  if (known_.size() >= known_max && !known_.contains(to)) known_.clear();
  std::shared_ptr<Destination>& destination = known_[to];
  if (destination == nullptr) destination = side_->destinations.find({.ip = to.ip, .port = to.port});
  std::array<std::byte, datagram_bytes_min> bytes;
  encode(ack, bytes.data());
  const iovec part{bytes.data(), ack.bytes()};
  const OutgoingBatch batch{{&part, 1}, 0};
  destination->note(destination->connection().try_send({&batch, 1}).outcome);
}

}  // namespace sft::udp
