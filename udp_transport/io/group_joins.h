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

/// Joins and leaves multicast groups. Must be used by the receiving thread only.
class GroupJoins {
 public:
  /// The maximum number of joined groups. Linux allows a socket 20 memberships by default.
  static constexpr std::size_t joins_max = 16;

  explicit GroupJoins(std::shared_ptr<const UdpSocket> socket) : socket_(std::move(socket)) {}

  /// Joins the group on the link by which `towards` is reached. Does nothing if `joins_max` groups are
  /// joined already. Then the writer of the group gets no report of its probe, and sends to this process by
  /// unicast. Leaving the oldest group instead would lose samples of its writer until that writer noticed,
  /// and its next join would in turn displace another group. If the group was joined before and `anew` is
  /// set, the group is left first, because only that makes the system report the membership to switches
  /// again.
  void join(std::uint32_t group, const SocketAddress& towards, bool anew) noexcept;
  /// Leaves all groups that are not in `groups`.
  void keep_to(std::span<const std::uint32_t> groups) noexcept;

 private:
  struct Joined {
    std::uint32_t group = 0;
    std::uint32_t own = 0;  ///< our IPv4 address on the link of the group
    friend bool operator==(const Joined&, const Joined&) = default;
  };
  void set(int option, const Joined& joined) noexcept;

  const std::shared_ptr<const UdpSocket> socket_;
  std::vector<Joined> joined_;
};

}  // namespace sft::udp
