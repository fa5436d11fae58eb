// Sends acks to the writers that are heard reliably, and reports to all who ask for them. Of the receiving
// thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <span>

#include "udp_transport/datagram.h"
#include "udp_transport/send_side.h"

namespace sft::udp {

class AckSender {
 public:
  explicit AckSender(std::shared_ptr<SendSide> side) : side_(std::move(side)) {}

  /// Now or not at all: where one does not leave, another will follow.
  void send(const SocketAddress& to, const Ack& ack);
  void send(const SocketAddress& to, const FlowReport& report);
  void send(const SocketAddress& to, const GroupReport& report);

 private:
  void send(const SocketAddress& to, std::span<const std::byte> bytes);

  static constexpr std::size_t known_max = 256;  ///< others come anew
  struct Known {
    std::shared_ptr<Destination> destination;
    std::uint64_t used_at = 0;  ///< by what was sent_ then
  };
  void forget_one_too_many();
  const std::shared_ptr<SendSide> side_;
  std::map<SocketAddress, Known> known_;
  std::uint64_t sent_ = 0;
};

}  // namespace sft::udp
