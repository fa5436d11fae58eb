#include "bench/udp/control_counter.h"

#include <arpa/inet.h>
#include <linux/filter.h>
#include <linux/if_ether.h>
#include <linux/if_packet.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <cstdio>
#include <cstdlib>

#include "examples/demo/network.h"

namespace sft::bench {

namespace {

constexpr int buffer_bytes = 16 << 20;  // nothing is taken out before the end

// Offsets in an Ethernet frame, and in the IPv4 packet in it.
constexpr std::uint32_t ether_type = 12;
constexpr std::uint32_t ip_header = 14;
constexpr std::uint32_t ip_fragment = ip_header + 6;
constexpr std::uint32_t ip_protocol = ip_header + 9;
constexpr std::uint32_t udp_payload = ip_header + 8;  // behind the IP header

// The first byte of a datagram (udp_transport/wire/datagram.h): version and kind.
constexpr std::uint32_t version_1 = 0x10;
constexpr std::uint32_t version_bits = 0xf0;
constexpr std::uint32_t first = version_1 | 1;
constexpr std::uint32_t following = version_1 | 2;
constexpr std::uint32_t packed = version_1 | 5;
constexpr std::uint32_t whole = version_1 | 10;

/// Accepts what is of SFT and no part of a sample. The last two figures of a jump are how many lines to skip
/// if the condition holds and if not.
constexpr std::array control_only{
    sock_filter BPF_STMT(BPF_LD | BPF_H | BPF_ABS, ether_type),
    sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, ETH_P_IP, 0, 13),
    sock_filter BPF_STMT(BPF_LD | BPF_B | BPF_ABS, ip_protocol),
    sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, IPPROTO_UDP, 0, 11),
    sock_filter BPF_STMT(BPF_LD | BPF_H | BPF_ABS, ip_fragment),
    sock_filter BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, 0x1fff, 9, 0),
    sock_filter BPF_STMT(BPF_LDX | BPF_B | BPF_MSH, ip_header),  // X = length of the IP header
    sock_filter BPF_STMT(BPF_LD | BPF_B | BPF_IND, udp_payload),
    sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, first, 6, 0),
    sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, following, 5, 0),
    sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, packed, 4, 0),
    sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, whole, 3, 0),
    sock_filter BPF_STMT(BPF_ALU | BPF_AND | BPF_K, version_bits),
    sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, version_1, 0, 1),
    sock_filter BPF_STMT(BPF_RET | BPF_K, 0xffffffff),
    sock_filter BPF_STMT(BPF_RET | BPF_K, 0),
};

}  // namespace

ControlCounter::ControlCounter() : packets_(socket(AF_PACKET, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)) {
  const sock_fprog filter{.len = control_only.size(),
                          .filter = const_cast<sock_filter*>(control_only.data())};
  setsockopt(packets_.get(), SOL_SOCKET, SO_RCVBUF, &buffer_bytes, sizeof buffer_bytes);
  const int filtered = setsockopt(packets_.get(), SOL_SOCKET, SO_ATTACH_FILTER, &filter, sizeof filter);
  // Bound to all protocols only once the filter is in place.
  sockaddr_ll address{};
  address.sll_family = AF_PACKET;
  address.sll_protocol = htons(ETH_P_ALL);
  address.sll_ifindex = static_cast<int>(if_nametoindex(demo::host_interface));
  if (filtered == 0 &&
      bind(packets_.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) {
    return;
  }
  std::perror("the control traffic cannot be counted");
  std::exit(1);
}

ControlTraffic ControlCounter::read() const {
  ControlTraffic traffic;
  char unused = 0;
  // MSG_TRUNC: the length of the frame, of which a byte is enough.
  for (ssize_t bytes = 0; (bytes = recv(packets_.get(), &unused, 1, MSG_TRUNC)) > 0;) {
    traffic.bytes += bytes;
    ++traffic.datagrams;
  }
  tpacket_stats statistics{};
  socklen_t length = sizeof statistics;
  getsockopt(packets_.get(), SOL_PACKET, PACKET_STATISTICS, &statistics, &length);
  if (statistics.tp_drops == 0) return traffic;
  std::fprintf(stderr, "%u datagrams of the control traffic could not be counted\n", statistics.tp_drops);
  std::exit(1);
}

}  // namespace sft::bench
