#include "udp_transport/ack_sender.h"

#include <algorithm>
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
  Known& known = known_[to];
  known.used_at = ++sent_;
  if (known.destination == nullptr) {
    forget_one_too_many();
    known.destination = side_->destinations.find({.ip = to.ip, .port = to.port});
  }
  known.destination->note(send_one(known.destination->connection(), bytes));
}

/// Who invents addresses drives out no other that is in use.
void AckSender::forget_one_too_many() {
  if (known_.size() <= known_max) return;
  known_.erase(std::ranges::min_element(known_, {}, [](const auto& item) { return item.second.used_at; }));
}

}  // namespace sft::udp
