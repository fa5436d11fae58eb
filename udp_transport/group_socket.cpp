#include "udp_transport/group_socket.h"

#include <netinet/in.h>
#include <netinet/udp.h>

#include <algorithm>

#include "udp_transport/datagram.h"
#include "udp_transport/interfaces.h"

namespace sft::udp {

namespace {

/// Ours on the way there; 0: there is none.
std::uint32_t own_address_towards(const SocketAddress& to) noexcept {
  const FileDescriptor probe(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  const sockaddr_in there = to_sockaddr(to);
  sockaddr_in own{};
  socklen_t size = sizeof own;
  const bool known = ::connect(probe.get(), reinterpret_cast<const sockaddr*>(&there), sizeof there) == 0 &&
                     ::getsockname(probe.get(), reinterpret_cast<sockaddr*>(&own), &size) == 0;
  return known ? to_address(own).ipv4 : 0;
}

}  // namespace

FileDescriptor open_group_socket(const SocketOptions& options) noexcept {
  FileDescriptor socket(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  if (!socket) return socket;
  const int fd = socket.get();
  set_int(fd, SOL_SOCKET, SO_REUSEADDR, 1);
  set_int(fd, IPPROTO_IP, IP_MULTICAST_ALL, 0);  // not what others of this host have joined
  set_receive_buffer(fd, options.receive_buffer_bytes);
  set_int(fd, SOL_UDP, UDP_GRO, 1);
  const sockaddr_in address = to_sockaddr({INADDR_ANY, group_port});
  if (::bind(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) return {};
  return socket;
}

void send_to_groups_by(int fd, const SocketAddress& own) noexcept {
  const in_addr link = to_sockaddr(own).sin_addr;
  ::setsockopt(fd, IPPROTO_IP, IP_MULTICAST_IF, &link, sizeof link);
  set_int(fd, IPPROTO_IP, IP_MULTICAST_TTL, 1);
  set_int(fd, IPPROTO_IP, IP_MULTICAST_LOOP, 0);
}

void GroupJoins::set(int option, const Joined& joined) noexcept {
  if (!socket_->group_fd) return;
  const ip_mreq request{.imr_multiaddr = {htonl(joined.group)}, .imr_interface = {htonl(joined.own)}};
  ::setsockopt(socket_->group_fd.get(), IPPROTO_IP, option, &request, sizeof request);
}

void GroupJoins::join(std::uint32_t group, const SocketAddress& towards) noexcept {
  const Joined wanted{group, own_address_towards(towards)};
  if (wanted.own == 0) return;
  if (const auto known = std::ranges::find(joined_, wanted); known != joined_.end()) {
    std::rotate(known, known + 1, joined_.end());
    return;
  }
  if (joined_.size() == joins_max) {
    set(IP_DROP_MEMBERSHIP, joined_.front());
    joined_.erase(joined_.begin());
  }
  set(IP_ADD_MEMBERSHIP, wanted);
  joined_.push_back(wanted);
}

void GroupJoins::keep_to(std::span<const std::uint32_t> groups) noexcept {
  std::erase_if(joined_, [&](const Joined& joined) {
    if (std::ranges::find(groups, joined.group) != groups.end()) return false;
    set(IP_DROP_MEMBERSHIP, joined);
    return true;
  });
}

}  // namespace sft::udp
