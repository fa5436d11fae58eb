// Counts the bytes of samples that an interface of this host sends. The interface's own counters would
// include other traffic: heartbeats, offers, and packets of the kernel.
#pragma once

#include <arpa/inet.h>
#include <linux/if_packet.h>
#include <net/ethernet.h>
#include <net/if.h>
#include <netinet/ip.h>
#include <netinet/udp.h>
#include <sys/socket.h>

#include <cstddef>
#include <cstring>
#include <span>
#include <string>
#include <vector>

#include "core/platform/file_descriptor.h"
#include "tests/support/parse_datagram.h"
#include "udp_transport/wire/datagram.h"

namespace sft::udp::test {

class SampleTap {
 public:
  explicit SampleTap(const std::string& interface)
      // With protocol 0, the socket receives nothing yet.
      : socket_(::socket(AF_PACKET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)) {
    sockaddr_ll place{};
    place.sll_family = AF_PACKET;
    place.sll_protocol = htons(ETH_P_ALL);
    place.sll_ifindex = static_cast<int>(::if_nametoindex(interface.c_str()));
    open_ = place.sll_ifindex > 0 &&  // the index 0 would stand for all interfaces
            ::bind(socket_.get(), reinterpret_cast<const sockaddr*>(&place), sizeof place) == 0;
  }
  bool is_open() const { return open_; }

  /// Returns the number of bytes in datagrams with samples that were sent over IPv4 since the last call.
  /// Headers of SFT count, those of UDP and IP do not.
  std::size_t bytes() {
    std::size_t sum = 0;
    sockaddr_ll from{};
    for (;;) {
      socklen_t from_bytes = sizeof from;
      const ssize_t bytes = ::recvfrom(socket_.get(), frame_.data(), frame_.size(), 0,
                                       reinterpret_cast<sockaddr*>(&from), &from_bytes);
      if (bytes < 0) return sum;
      if (from.sll_pkttype == PACKET_OUTGOING && from.sll_protocol == htons(ETH_P_IP))
        sum += bytes_of_samples(std::span(frame_).first(static_cast<std::size_t>(bytes)));
    }
  }

 private:
  static std::size_t bytes_of_samples(std::span<const std::byte> frame) {
    iphdr ip{};
    if (frame.size() < sizeof ip) return 0;
    std::memcpy(&ip, frame.data(), sizeof ip);
    const std::size_t headers_bytes = ip.ihl * std::size_t{4} + sizeof(udphdr);
    if (ip.protocol != IPPROTO_UDP || frame.size() <= headers_bytes) return 0;
    // a frame may contain several datagrams of the same kind, joined by an offload
    const auto datagrams = frame.subspan(headers_bytes);
    return is_of_sample(kind_of(datagrams).value_or(DatagramKind::heartbeat)) ? datagrams.size() : 0;
  }

  core::FileDescriptor socket_;
  bool open_ = false;
  std::vector<std::byte> frame_ = std::vector<std::byte>(65'536);
};

}  // namespace sft::udp::test
