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
/// The same value as Cyclone's default (General/MulticastTimeToLive).
constexpr int socket_buffer_bytes = 1 << 20;

sockaddr_in ddsi_address_at(std::uint16_t port) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = htonl(ddsi_group);
  return address;
}

using ControlData = std::array<std::byte, CMSG_SPACE(sizeof(timespec))>;

std::chrono::nanoseconds since_epoch(const timespec& time) {
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

/// Returns how long ago the system received the datagram; 0 if it does not report that, or if the system's
/// clock was set meanwhile.
std::chrono::nanoseconds age_of(msghdr& datagram, std::chrono::nanoseconds now) {
  for (cmsghdr* one = CMSG_FIRSTHDR(&datagram); one != nullptr; one = CMSG_NXTHDR(&datagram, one)) {
    if (one->cmsg_level != SOL_SOCKET || one->cmsg_type != SCM_TIMESTAMPNS) continue;
    timespec received{};
    std::memcpy(&received, CMSG_DATA(one), sizeof received);
    return std::max(now - since_epoch(received), std::chrono::nanoseconds(0));
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
std::optional<HeartbeatSocket> HeartbeatSocket::open(const Place& place) noexcept {
  FileDescriptor socket(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  ip_mreqn link{};
  link.imr_multiaddr.s_addr = htonl(ddsi_group);
  link.imr_address.s_addr = htonl(place.ip.ipv4());
  link.imr_ifindex = static_cast<int>(place.index);
  const sockaddr_in address = ddsi_address_at(place.port);
  set_option(socket, SOL_SOCKET, SO_RCVBUF, socket_buffer_bytes);
  const bool is_ready =
      socket && set_option(socket, SOL_SOCKET, SO_REUSEADDR, 1) &&
      set_option(socket, IPPROTO_IP, IP_MULTICAST_ALL, 0) &&
      set_option(socket, IPPROTO_IP, IP_MULTICAST_IF, link) &&
      set_option(socket, IPPROTO_IP, IP_MULTICAST_TTL, hops_max) &&
      set_option(socket, IPPROTO_IP, IP_MULTICAST_LOOP, place.reaches_own_host ? 1 : 0) &&
      ::bind(socket.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 &&
      set_option(socket, IPPROTO_IP, IP_ADD_MEMBERSHIP, link);
  if (!is_ready) return std::nullopt;
  set_option(socket, SOL_SOCKET, SO_TIMESTAMPNS, 1);
  return HeartbeatSocket(std::move(socket), place.port);
}

void HeartbeatSocket::send(const Heartbeat& heartbeat) const noexcept {
  const HeartbeatDatagram datagram = encode(heartbeat);
  const sockaddr_in to = ddsi_address_at(port_);
  ::sendto(socket_.get(), datagram.data(), datagram.size(), 0, reinterpret_cast<const sockaddr*>(&to),
           sizeof to);
}

/// Receives at most `batch` datagrams, and returns their number.
std::size_t HeartbeatSocket::receive() noexcept {
  std::array<iovec, batch> places{};
  std::array<mmsghdr, batch> datagrams{};
  std::array<sockaddr_in, batch> senders{};
  alignas(cmsghdr) std::array<ControlData, batch> control_data;
  for (std::size_t i = 0; i < batch; ++i) {
    places[i] = {buffers_[i].data(), buffers_[i].size()};
    datagrams[i].msg_hdr.msg_name = &senders[i];
    datagrams[i].msg_hdr.msg_namelen = sizeof senders[i];
    datagrams[i].msg_hdr.msg_iov = &places[i];
    datagrams[i].msg_hdr.msg_iovlen = 1;
    datagrams[i].msg_hdr.msg_control = control_data[i].data();
    datagrams[i].msg_hdr.msg_controllen = control_data[i].size();
  }
  const int came = ::recvmmsg(socket_.get(), datagrams.data(), batch, MSG_DONTWAIT, nullptr);
  if (came <= 0) return 0;
  timespec now{};
  ::clock_gettime(CLOCK_REALTIME, &now);
  for (std::size_t i = 0; i < static_cast<std::size_t>(came); ++i) {
    sizes_[i] = datagrams[i].msg_len;
    ages_[i] = age_of(datagrams[i].msg_hdr, since_epoch(now));
    senders_[i] = ntohl(senders[i].sin_addr.s_addr);
  }
  return static_cast<std::size_t>(came);
}

}  // namespace sft::core
