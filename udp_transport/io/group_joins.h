// The multicast groups that a process has joined.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <utility>
#include <vector>

#include "udp_transport/io/udp_socket.h"

namespace sft::udp {

/// Used by the receiving thread only.
class GroupJoins {
 public:
  /// By default, Linux allows a socket 20 memberships.
  static constexpr std::size_t joins_max = 16;

  explicit GroupJoins(std::shared_ptr<const UdpSocket> socket) : socket_(std::move(socket)) {}

  /// Joins the group on the link by which `towards` is reached, unless there are `joins_max` already. Then
  /// its writer gets no report of a probe, and serves this process alone. If the oldest group were left
  /// instead, samples of its writer would be lost until that writer noticed, and then that group would in
  /// turn displace another one. If the group was joined before and `anew` is set, it is left first: only
  /// that makes the system report the membership to switches again.
  void join(std::uint32_t group, const SocketAddress& towards, bool anew) noexcept;
  /// Leaves all groups but these.
  void keep_to(std::span<const std::uint32_t> groups) noexcept;

 private:
  struct Joined {
    std::uint32_t group = 0;
    std::uint32_t own = 0;  ///< our address on the link of the group
    friend bool operator==(const Joined&, const Joined&) = default;
  };
  void set(int option, const Joined& joined) noexcept;

  const std::shared_ptr<const UdpSocket> socket_;
  std::vector<Joined> joined_;
};

}  // namespace sft::udp
