// Divides the receive buffer of our socket among its present senders. All senders together may have no more
// bytes under way than the buffer holds. Each address gets the same share, which its senders divide. The
// class uses no clock, thread or I/O.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "udp_transport/io/datagram_io.h"
#include "udp_transport/wire/datagram.h"

namespace sft::udp {

class ReceiveShares {
 public:
  using Time = std::chrono::steady_clock::time_point;
  /// The maximum number of senders that get a share. A sender gets one by its first flow mark. The reports
  /// to further senders grant only a very small share.
  static constexpr std::size_t senders_max = 256;
  /// A sender that has sent no flow mark (request for a report) for this time gets no share of the receive
  /// buffer any more.
  static constexpr std::chrono::milliseconds at_rest_after{500};
  static constexpr std::size_t of_one_address_max = 64;

  explicit ReceiveShares(std::size_t receive_buffer_bytes);

  /// Counts a datagram that has come from that address.
  void count(const SocketAddress& from) {
    if (last_ < senders_.size() && senders_[last_].from == from) {
      ++senders_[last_].came;
    } else {
      find_and_count(from);
    }
  }
  /// Returns the report that answers the flow mark.
  FlowReport answer(const FlowMark& mark, const SocketAddress& from, Time now);

  std::size_t senders() const { return senders_.size(); }

 private:
  struct Sender {
    SocketAddress from;
    std::uint32_t flow = 0;
    /// The number of datagrams that have come, plus those that were sent before the sender was known.
    std::uint32_t came = 0;
    std::size_t granted = 0;  ///< the share in the last report to the sender
    Time marked_at{};
  };
  void find_and_count(const SocketAddress& from);
  std::size_t grant(Sender& sender) const;
  auto of_address(const core::IpAddress& ip) const;
  std::size_t addresses() const;
  Sender* known_or_new(const FlowMark& mark, const SocketAddress& from);

  const std::size_t usable_bytes_;
  std::vector<Sender> senders_;  ///< sorted by address
  std::size_t last_ = 0;         ///< index of the sender of the latest datagram
};

}  // namespace sft::udp
