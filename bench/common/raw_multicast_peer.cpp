#include <arpa/inet.h>
#include <net/if.h>
#include <netinet/udp.h>
#include <sys/socket.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <thread>
#include <vector>

#include "bench/common/message_set.h"
#include "tools/hosts/network.h"

namespace sft::bench {

namespace {

constexpr std::uint16_t port = 45'901;
constexpr int datagram_bytes = 1472;  // the payload of a packet of 1,500 bytes

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

/// Ends the process if `done` is false, because the system has refused a call.
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
  set(fd, SOL_SOCKET, SO_REUSEADDR, 1);  // needed for several readers on one host
  const sockaddr_in here = address(INADDR_ANY);
  must(bind(fd, reinterpret_cast<const sockaddr*>(&here), sizeof here) == 0);
  set(fd, IPPROTO_IP, IP_ADD_MEMBERSHIP, on_the_link());
  return fd;
}

/// Receives samples. A datagram that is not full is the last datagram of a sample.
[[noreturn]] void receive(int socket, const Arrived& arrived) {
  std::array<std::uint8_t, datagram_bytes> datagram{};
  for (;;) {
    const ssize_t bytes = recv(socket, datagram.data(), datagram.size(), 0);
    if (bytes < datagram_bytes) arrived(0);
  }
}

class RawMulticastWriter : public Writer {
 public:
  explicit RawMulticastWriter(const Topic& topic)
      : socket_(sending_socket()), sample_(topic.messages->largest()), readers_(topic.readers) {}
  ~RawMulticastWriter() override { close(socket_); }

  std::size_t readers() const override { return readers_; }
  void write(std::uint64_t) override {
    const sockaddr_in to = group();
    must(sendto(socket_, sample_.data(), sample_.size(), 0, reinterpret_cast<const sockaddr*>(&to),
                sizeof to) > 0);
  }

 private:
  const int socket_;
  const std::vector<std::uint8_t> sample_;
  const std::size_t readers_;
};

/// A reader whose thread reads until the process ends.
class RawMulticastReader : public Reader {
 public:
  explicit RawMulticastReader(const Arrived& arrived) {
    std::thread([arrived, socket = receiving_socket()] { receive(socket, arrived); }).detach();
  }
  std::size_t writers() const override { return 1; }
};

class RawMulticastPeer : public Peer {
 public:
  std::unique_ptr<Writer> writer(const Topic& topic) override {
    return std::make_unique<RawMulticastWriter>(topic);
  }
  std::unique_ptr<Reader> reader(const Topic&, Arrived arrived) override {
    return std::make_unique<RawMulticastReader>(arrived);
  }
};

}  // namespace

std::unique_ptr<Peer> raw_multicast_peer() { return std::make_unique<RawMulticastPeer>(); }

}  // namespace sft::bench
