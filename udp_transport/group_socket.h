// How datagrams of multicast groups enter a process, and how others leave for them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "udp_transport/udp_socket.h"

namespace sft::udp {

/// A second socket beside the one that receives, bound to the port of groups, which processes of a host
/// share; it hears none until it joins. None where that port is not to be had.
void open_group_socket(UdpSocket& socket) noexcept;

/// What is sent to groups by this socket leaves where the host has that IPv4 address, and goes no further
/// than the link. It does not come back to this host: who is reached by loopback is in no group.
void send_to_groups_by(int fd, const SocketAddress& own) noexcept;

/// The groups that a process is in. Of the receiving thread.
class GroupJoins {
 public:
  /// A socket may be in 20 at a time, unless the system was told otherwise.
  static constexpr std::size_t joins_max = 16;

  explicit GroupJoins(std::shared_ptr<const UdpSocket> socket) : socket_(std::move(socket)) {}

  /// On the link by which `towards` is reached. Of too many the oldest goes. One that was joined before is
  /// left first if `anew`: that alone makes the system report the membership to switches again.
  void join(std::uint32_t group, const SocketAddress& towards, bool anew) noexcept;
  /// Leaves all but these.
  void keep_to(std::span<const std::uint32_t> groups) noexcept;

 private:
  struct Joined {
    std::uint32_t group = 0;
    std::uint32_t own = 0;  ///< address on its link
    friend bool operator==(const Joined&, const Joined&) = default;
  };
  void set(int option, const Joined& joined) noexcept;

  const std::shared_ptr<const UdpSocket> socket_;
  std::vector<Joined> joined_;  ///< the newest last
};

}  // namespace sft::udp
