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
  /// A socket may be in 20 at a time, unless the system was told otherwise.
  static constexpr std::size_t joins_max = 16;

  explicit GroupJoins(std::shared_ptr<const UdpSocket> socket) : socket_(std::move(socket)) {}

  /// Joins the group on the link by which `towards` is reached, if there are not too many already: its writer
  /// then hears that no probe comes, and serves this process alone. If the oldest were left instead, what
  /// that one's writer sends would be lost until it has noticed, and that group would take the next one's
  /// place. A group that was joined before is left first if `anew`: that alone makes the system report the
  /// membership to switches again.
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
  std::vector<Joined> joined_;
};

}  // namespace sft::udp
