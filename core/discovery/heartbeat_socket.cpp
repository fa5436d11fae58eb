#include "core/discovery/heartbeat_socket.h"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/uio.h>

#include <algorithm>
#include <cstring>
#include <ctime>

namespace sft::core {

namespace {

/// The group by which participants of DDS find each other (RTPS 2.3, 9.6.1.4): if the network forwards
/// Cyclone's multicasts, it also forwards heartbeats to the same group.
constexpr std::uint32_t ddsi_group = 0xefff0001;  // 239.255.0.1
/// Cyclone's default (General/MulticastTimeToLive).
constexpr int hops_max = 32;
constexpr int socket_buffer_bytes = 1 << 20;

sockaddr_in ddsi_address_at(std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(ddsi_group);
  return address;
}

std::chrono::nanoseconds since_epoch(const timespec& time) {
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

/// Returns how long ago the system received the datagram; 0 if it does not report that, or if the system's
/// clock was set meanwhile.
std::chrono::nanoseconds age_of(msghdr& datagram) {
  for (cmsghdr* one = CMSG_FIRSTHDR(&datagram); one != nullptr; one = CMSG_NXTHDR(&datagram, one)) {
    if (one->cmsg_level != SOL_SOCKET || one->cmsg_type != SCM_TIMESTAMPNS) continue;
    timespec received{}, now{};
    std::memcpy(&received, CMSG_DATA(one), sizeof received);
    ::clock_gettime(CLOCK_REALTIME, &now);
    return std::max(since_epoch(now) - since_epoch(received), std::chrono::nanoseconds(0));
  }
  return {};
}

template <class Value>
bool set_option(const FileDescriptor& socket, int level, int name, const Value& value) {
  return ::setsockopt(socket.get(), level, name, &value, sizeof value) == 0;
}

}  // namespace

/// All processes of the host bind sockets to the same port, and each of these sockets gets each datagram.
/// The socket is bound to the group, so it receives no datagrams to other addresses. It also receives no
/// datagrams from other interfaces.
std::optional<HeartbeatSocket> HeartbeatSocket::open(const LinkSpec& link, std::uint16_t port) noexcept {
  FileDescriptor socket(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  ip_mreqn group{};
  group.imr_multiaddr.s_addr = htonl(ddsi_group);
  group.imr_address.s_addr = htonl(link.ip.ipv4());
  group.imr_ifindex = static_cast<int>(link.index);
  const sockaddr_in address = ddsi_address_at(port);
  set_option(socket, SOL_SOCKET, SO_RCVBUF, socket_buffer_bytes);
  const bool is_ready =
      socket && set_option(socket, SOL_SOCKET, SO_REUSEADDR, 1) &&
      set_option(socket, IPPROTO_IP, IP_MULTICAST_ALL, 0) &&
      set_option(socket, IPPROTO_IP, IP_MULTICAST_IF, group) &&
      set_option(socket, IPPROTO_IP, IP_MULTICAST_TTL, hops_max) &&
      set_option(socket, IPPROTO_IP, IP_MULTICAST_LOOP, link.reaches_own_host ? 1 : 0) &&
      ::bind(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 &&
      set_option(socket, IPPROTO_IP, IP_ADD_MEMBERSHIP, group);
  if (!is_ready) return std::nullopt;
  set_option(socket, SOL_SOCKET, SO_TIMESTAMPNS, 1);
  return HeartbeatSocket(std::move(socket), port);
}

void HeartbeatSocket::send(const Heartbeat& heartbeat) const noexcept {
  const HeartbeatDatagram datagram = encode(heartbeat);
  const sockaddr_in to = ddsi_address_at(port_);
  ::sendto(socket_.get(), datagram.data(), datagram.size(), 0, reinterpret_cast<const sockaddr*>(&to),
           sizeof to);
}

/// Returns false if no datagram has come.
bool HeartbeatSocket::receive(Received& into) const noexcept {
  alignas(cmsghdr) std::array<char, CMSG_SPACE(sizeof(timespec))> control_data{};
  sockaddr_in sender{};
  iovec octets{into.octets.data(), into.octets.size()};
  msghdr datagram{};
  datagram.msg_name = &sender;
  datagram.msg_namelen = sizeof sender;
  datagram.msg_iov = &octets;
  datagram.msg_iovlen = 1;
  datagram.msg_control = control_data.data();
  datagram.msg_controllen = control_data.size();
  const ssize_t size = ::recvmsg(socket_.get(), &datagram, MSG_DONTWAIT);
  if (size < 0) return false;
  into.size = static_cast<std::size_t>(size);
  into.age = age_of(datagram);
  into.from = ntohl(sender.sin_addr.s_addr);
  return true;
}

}  // namespace sft::core
