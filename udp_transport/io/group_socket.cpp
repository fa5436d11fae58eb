#include "udp_transport/io/group_socket.h"

#include <netinet/in.h>
#include <netinet/udp.h>
#include <sys/epoll.h>

#include "udp_transport/io/interfaces.h"
#include "udp_transport/io/socket_settings.h"
#include "udp_transport/wire/datagram.h"

namespace sft::udp {

namespace {

FileDescriptor open_for_groups(std::size_t receive_buffer_bytes) noexcept {
  FileDescriptor socket(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  if (!socket) return socket;
  const int fd = socket.get();
  set_int(fd, SOL_SOCKET, SO_REUSEADDR, 1);
  // With this option, the socket receives no datagrams of groups that only other processes have joined.
  set_int(fd, IPPROTO_IP, IP_MULTICAST_ALL, 0);
  set_receive_buffer(fd, receive_buffer_bytes);
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

GroupSocket open_group_socket(int unicast_fd, std::size_t receive_buffer_bytes) noexcept {
  GroupSocket socket{.group_fd = open_for_groups(receive_buffer_bytes)};
  if (!socket.group_fd) return {};
  socket.either_fd = open_either(unicast_fd, socket.group_fd.get());
  if (!socket.either_fd) return {};
  return socket;
}

void send_to_groups_by(int fd, const SocketAddress& own) noexcept {
  const in_addr link{htonl(own.ip.ipv4())};
  ::setsockopt(fd, IPPROTO_IP, IP_MULTICAST_IF, &link, sizeof link);
  set_int(fd, IPPROTO_IP, IP_MULTICAST_TTL, 1);
  set_int(fd, IPPROTO_IP, IP_MULTICAST_LOOP, 0);
}

}  // namespace sft::udp
