#include "tests/hostile/wire.h"

#include <arpa/inet.h>
#include <linux/if_packet.h>
#include <net/ethernet.h>
#include <net/if.h>
#include <netinet/ip.h>
#include <netinet/udp.h>
#include <sys/ioctl.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <string_view>
#include <system_error>

namespace sft::hostile {

namespace {

constexpr std::size_t headers_bytes = sizeof(iphdr) + sizeof(udphdr);
constexpr std::size_t frame_bytes_max = 2048;
constexpr std::uint16_t dds_ports_begin = 7400;
constexpr std::uint16_t dds_ports_end = 7660;

int checked(int result, const char* what) {
  if (result < 0) throw std::system_error(errno, std::generic_category(), what);
  return result;
}

const sockaddr* generic(const sockaddr_in& address) { return reinterpret_cast<const sockaddr*>(&address); }

std::uint16_t port_of(int socket) {
  sockaddr_in address{};
  socklen_t length = sizeof address;
  getsockname(socket, reinterpret_cast<sockaddr*>(&address), &length);
  return ntohs(address.sin_port);
}

int bound_socket() {
  const int socket = checked(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0), "socket");
  sockaddr_in any{};
  any.sin_family = AF_INET;
  checked(bind(socket, generic(any), sizeof any), "bind");
  return socket;
}

bool looks_like_sft(std::span<const std::byte> payload) {
  if (payload.size() < udp::following_header_bytes) return false;
  const auto version = std::to_integer<unsigned>(payload[0]) >> 4;
  const auto kind = std::to_integer<unsigned>(payload[0]) & 15;
  return version == udp::wire_version && kind >= 1 && kind <= static_cast<unsigned>(udp::DatagramKind::far);
}

/// Returns true for messages of RTPS and for heartbeats of participants.
bool looks_like_control(std::span<const std::byte> payload) {
  const auto begins_with = [&](std::string_view magic) {
    return payload.size() >= magic.size() && std::memcmp(payload.data(), magic.data(), magic.size()) == 0;
  };
  return begins_with("RTPS") || begins_with("SHB");
}

bool is_of(Listener::Traffic traffic, std::uint16_t port, std::span<const std::byte> payload) {
  if (traffic == Listener::Traffic::control) return looks_like_control(payload);
  return (port < dds_ports_begin || port >= dds_ports_end) && looks_like_sft(payload);
}

/// Makes the socket send multicasts through eth0. Returns the socket.
int with_multicast(int socket) {
  ip_mreqn interface {};
  interface.imr_ifindex = static_cast<int>(if_nametoindex("eth0"));
  setsockopt(socket, IPPROTO_IP, IP_MULTICAST_IF, &interface, sizeof interface);
  return socket;
}

/// Returns the datagram in the frame; empty if the datagram does not belong to that traffic.
Overheard parse_frame(std::span<const std::byte> frame, Listener::Traffic traffic) {
  iphdr ip{};
  udphdr udp{};
  if (frame.size() < headers_bytes) return {};
  std::memcpy(&ip, frame.data(), sizeof ip);
  const std::size_t ip_bytes = ip.ihl * std::size_t{4};
  if (ip.version != 4 || ip.protocol != IPPROTO_UDP || frame.size() < ip_bytes + sizeof udp) return {};
  std::memcpy(&udp, frame.data() + ip_bytes, sizeof udp);
  const auto payload = frame.subspan(ip_bytes + sizeof udp);
  const std::uint16_t port = ntohs(udp.dest);
  if (!is_of(traffic, port, payload)) return {};
  Overheard heard;
  heard.from.sin_family = heard.to.sin_family = AF_INET;
  heard.from.sin_addr.s_addr = ip.saddr;
  heard.from.sin_port = udp.source;
  heard.to.sin_addr.s_addr = ip.daddr;
  heard.to.sin_port = udp.dest;
  heard.payload.assign(payload.begin(), payload.end());
  return heard;
}

}  // namespace

core::UdpAddress own_address(std::uint16_t port) {
  const int socket = checked(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0), "socket");
  ifreq request{};
  std::strcpy(request.ifr_name, "eth0");
  const int result = ioctl(socket, SIOCGIFADDR, &request);
  close(socket);
  checked(result, "eth0");
  sockaddr_in address{};
  std::memcpy(&address, &request.ifr_addr, sizeof address);
  return {
      .ip = core::IpAddress(ntohl(address.sin_addr.s_addr)), .port = port, .receive_buffer_bytes = 1U << 20};
}

sockaddr_in to_sockaddr(const core::UdpAddress& address) {
  sockaddr_in out{};
  out.sin_family = AF_INET;
  out.sin_port = htons(address.port);
  out.sin_addr.s_addr = htonl(address.ip.ipv4());
  return out;
}

sockaddr_in to_port(std::uint32_t address, std::uint16_t port) {
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_addr.s_addr = address;
  to.sin_port = htons(port);
  return to;
}

std::vector<sockaddr_in> addresses_of(const core::Endpoint& endpoint) {
  std::vector<sockaddr_in> found;
  for (const core::UdpAddress& address : endpoint.addresses) {
    if (address.ip.is_ipv4()) found.push_back(to_sockaddr(address));
  }
  return found;
}

Sender::Sender() : socket_(with_multicast(bound_socket())) {}
Sender::~Sender() { close(socket_); }
void Sender::send(std::span<const std::byte> datagram, const sockaddr_in& to) const {
  sendto(socket_, datagram.data(), datagram.size(), 0, generic(to), sizeof to);
}
std::uint16_t Sender::port() const { return port_of(socket_); }

Spoofer::Spoofer()
    : socket_(with_multicast(
          checked(::socket(AF_INET, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, IPPROTO_RAW), "raw socket"))) {}
Spoofer::~Spoofer() { close(socket_); }
void Spoofer::send(std::span<const std::byte> payload, const sockaddr_in& from, const sockaddr_in& to) const {
  iphdr ip{};
  ip.version = 4;
  ip.ihl = sizeof ip / 4;
  ip.ttl = 64;
  ip.protocol = IPPROTO_UDP;
  ip.saddr = from.sin_addr.s_addr;
  ip.daddr = to.sin_addr.s_addr;
  ip.tot_len = htons(static_cast<std::uint16_t>(headers_bytes + payload.size()));
  udphdr udp{};
  udp.source = from.sin_port;
  udp.dest = to.sin_port;
  udp.len = htons(static_cast<std::uint16_t>(sizeof udp + payload.size()));
  Bytes packet(headers_bytes + payload.size());
  std::memcpy(packet.data(), &ip, sizeof ip);
  std::memcpy(packet.data() + sizeof ip, &udp, sizeof udp);
  std::memcpy(packet.data() + headers_bytes, payload.data(), payload.size());
  sendto(socket_, packet.data(), packet.size(), 0, generic(to), sizeof to);
}

Drain::Drain() : socket_(bound_socket()), port_(port_of(socket_)) {
  constexpr int buffer_bytes = 4 * 1024 * 1024;
  setsockopt(socket_, SOL_SOCKET, SO_RCVBUFFORCE, &buffer_bytes, sizeof buffer_bytes);
}
Drain::~Drain() { close(socket_); }
std::uint64_t Drain::count() {
  std::array<char, 65'536> datagram{};
  for (;;) {
    const ssize_t bytes = recv(socket_, datagram.data(), datagram.size(), MSG_DONTWAIT);
    if (bytes < 0) return bytes_;
    bytes_ += static_cast<std::uint64_t>(bytes);
  }
}

Listener::Listener(Traffic traffic)
    : traffic_(traffic),
      socket_(checked(::socket(AF_PACKET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, htons(ETH_P_IP)),
                      "packet socket")) {}
Listener::~Listener() { close(socket_); }
std::vector<Overheard> Listener::listen() {
  std::vector<Overheard> heard;
  std::array<std::byte, frame_bytes_max> frame{};
  for (;;) {
    const ssize_t bytes = recv(socket_, frame.data(), frame.size(), MSG_DONTWAIT);
    if (bytes < 0) return heard;
    Overheard one = parse_frame({frame.data(), static_cast<std::size_t>(bytes)}, traffic_);
    if (!one.payload.empty()) heard.push_back(std::move(one));
  }
}

}  // namespace sft::hostile
