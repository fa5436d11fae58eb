#include "udp_transport/group_socket.h"

#include <netinet/in.h>
#include <netinet/udp.h>
#include <sys/epoll.h>

#include <algorithm>

#include "udp_transport/datagram.h"
#include "udp_transport/interfaces.h"

namespace sft::udp {

namespace {

/// Ours on the way there; none: there is no way, or not by IPv4.
core::IpAddress own_address_towards(const SocketAddress& to) noexcept {
  if (!to.ip.is_ipv4()) return {};
  const FileDescriptor probe(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  const SystemAddress there(to);
  sockaddr_in6 own{};
  socklen_t size = sizeof own;
  const bool known = ::connect(probe.get(), there.get(), there.bytes()) == 0 &&
                     ::getsockname(probe.get(), reinterpret_cast<sockaddr*>(&own), &size) == 0;
  return known ? to_address(own).ip : core::IpAddress{};
}

FileDescriptor open_for_groups(const SocketOptions& options) noexcept {
  FileDescriptor socket(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  if (!socket) return socket;
  const int fd = socket.get();
  set_int(fd, SOL_SOCKET, SO_REUSEADDR, 1);
  set_int(fd, IPPROTO_IP, IP_MULTICAST_ALL, 0);  // not what others of this host have joined
  set_receive_buffer(fd, options.receive_buffer_bytes);
  set_int(fd, SOL_UDP, UDP_GRO, 1);
  const SystemAddress any({{}, group_port}, AF_INET);
  if (::bind(fd, any.get(), any.bytes()) != 0) return {};
  return socket;
}

FileDescriptor open_either(int one, int other) noexcept {
  FileDescriptor either(::epoll_create1(EPOLL_CLOEXEC));
  for (const int fd : {one, other}) {
    epoll_event readable{.events = EPOLLIN, .data = {.fd = fd}};
    if (::epoll_ctl(either.get(), EPOLL_CTL_ADD, fd, &readable) != 0) return {};
  }
  return either;
}

}  // namespace

void open_group_socket(UdpSocket& socket) noexcept {
  socket.group_fd = open_for_groups(socket.options);
  if (!socket.group_fd) return;
  socket.either_fd = open_either(socket.fd.get(), socket.group_fd.get());
  if (!socket.either_fd) socket.group_fd = {};
}

void send_to_groups_by(int fd, const SocketAddress& own) noexcept {
  const in_addr link{htonl(own.ip.ipv4())};
  ::setsockopt(fd, IPPROTO_IP, IP_MULTICAST_IF, &link, sizeof link);
  set_int(fd, IPPROTO_IP, IP_MULTICAST_TTL, 1);
  set_int(fd, IPPROTO_IP, IP_MULTICAST_LOOP, 0);
}

void GroupJoins::set(int option, const Joined& joined) noexcept {
  if (!socket_->group_fd) return;
  const ip_mreq request{.imr_multiaddr = {htonl(joined.group)}, .imr_interface = {htonl(joined.own)}};
  ::setsockopt(socket_->group_fd.get(), IPPROTO_IP, option, &request, sizeof request);
}

void GroupJoins::join(std::uint32_t group, const SocketAddress& towards, bool anew) noexcept {
  const core::IpAddress own = own_address_towards(towards);
  if (!own.is_ipv4()) return;
  const Joined wanted{group, own.ipv4()};
  if (const auto known = std::ranges::find(joined_, wanted); known != joined_.end()) {
    std::rotate(known, known + 1, joined_.end());
    if (anew) set(IP_DROP_MEMBERSHIP, wanted);
    if (anew) set(IP_ADD_MEMBERSHIP, wanted);
    return;
  }
  if (joined_.size() == joins_max) {
    set(IP_DROP_MEMBERSHIP, joined_.front());
    joined_.erase(joined_.begin());
  }
  set(IP_ADD_MEMBERSHIP, wanted);
  socket_->in_groups.store(true, std::memory_order_relaxed);
  joined_.push_back(wanted);
}

void GroupJoins::keep_to(std::span<const std::uint32_t> groups) noexcept {
  std::erase_if(joined_, [&](const Joined& joined) {
    if (std::ranges::find(groups, joined.group) != groups.end()) return false;
    set(IP_DROP_MEMBERSHIP, joined);
    return true;
  });
  socket_->in_groups.store(!joined_.empty(), std::memory_order_relaxed);
}

}  // namespace sft::udp
