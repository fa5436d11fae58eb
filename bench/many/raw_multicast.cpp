#include "bench/many/raw_multicast.h"

#include <arpa/inet.h>
#include <net/if.h>
#include <netinet/udp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <thread>

#include "tools/hosts/network.h"

namespace sft::bench {

namespace {

constexpr std::uint16_t port = 45'901;
constexpr int datagram_bytes = 1472;  // of a packet of 1,500 bytes

sockaddr_in address(in_addr_t ip) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(port);
  address.sin_addr.s_addr = ip;
  return address;
}

sockaddr_in group() { return address(inet_addr("239.255.77.1")); }

ip_mreqn on_the_link() {
  ip_mreqn membership{};
  membership.imr_multiaddr = group().sin_addr;
  membership.imr_ifindex = static_cast<int>(if_nametoindex(hosts::host_interface));
  return membership;
}

/// Ends the process if the system refuses something.
void must(bool done) {
  if (!done) std::abort();
}

template <class Value>
void set(int socket, int level, int option, const Value& value) {
  must(setsockopt(socket, level, option, &value, sizeof value) == 0);
}

int sending_socket() {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  set(fd, IPPROTO_IP, IP_MULTICAST_IF, on_the_link());
  set(fd, SOL_UDP, UDP_SEGMENT, datagram_bytes);
  return fd;
}

int receiving_socket() {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  set(fd, SOL_SOCKET, SO_REUSEADDR, 1);  // several readers are on one host
  const sockaddr_in here = address(INADDR_ANY);
  must(bind(fd, reinterpret_cast<const sockaddr*>(&here), sizeof here) == 0);
  set(fd, IPPROTO_IP, IP_ADD_MEMBERSHIP, on_the_link());
  return fd;
}

/// The end of a sample is a datagram that is not full.
[[noreturn]] void receive(int socket, const std::function<void()>& arrived) {
  std::array<std::uint8_t, datagram_bytes> datagram{};
  for (;;) {
    const ssize_t bytes = recv(socket, datagram.data(), datagram.size(), 0);
    if (bytes < datagram_bytes) arrived();
  }
}

}  // namespace

RawMulticastMember::Writer::Writer(RawMulticastMember&, const Payload& payload)
    : socket_(sending_socket()), sample_(payload.sample_bytes) {}

RawMulticastMember::Writer::~Writer() { close(socket_); }

void RawMulticastMember::Writer::write() {
  const sockaddr_in to = group();
  must(sendto(socket_, sample_.data(), sample_.size(), 0, reinterpret_cast<const sockaddr*>(&to), sizeof to) >
       0);
}

RawMulticastMember::MaskedReader::MaskedReader(RawMulticastMember&, const Payload&,
                                               const std::function<void()>& arrived) {
  std::thread([arrived, socket = receiving_socket()] { receive(socket, arrived); }).detach();
}

}  // namespace sft::bench
