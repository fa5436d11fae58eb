#include "bench/udp/control_counter.h"

#include <linux/if_ether.h>
#include <linux/if_packet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <cstdio>
#include <cstdlib>

#include "tools/hosts/network.h"
#include "tools/hosts/packet_filter.h"
#include "udp_transport/wire/datagram.h"

namespace sft::bench {

namespace {

constexpr int buffer_bytes = 16 << 20;  // room for all datagrams, since none is read before the end

using namespace hosts;  // for the offsets in a frame

// The first byte of a datagram, which has its version and kind (udp_transport/wire/datagram.h).
constexpr std::uint32_t version = udp::wire_version << 4;
constexpr std::uint32_t version_bits = 0xf0;
constexpr std::uint32_t first_byte(udp::DatagramKind kind) {
  return version | static_cast<std::uint32_t>(kind);
}
constexpr std::uint32_t first = first_byte(udp::DatagramKind::first);
constexpr std::uint32_t following = first_byte(udp::DatagramKind::following);
constexpr std::uint32_t far = first_byte(udp::DatagramKind::far);
constexpr std::uint32_t packed = first_byte(udp::DatagramKind::packed);
constexpr std::uint32_t whole = first_byte(udp::DatagramKind::whole);
constexpr std::uint32_t single = first_byte(udp::DatagramKind::single);

/// A filter that accepts datagrams of SFT without a part of a sample. The last two numbers of a jump are
/// the numbers of lines to skip if the condition holds, and if it does not.
constexpr std::array control_only{
    sock_filter BPF_STMT(BPF_LD | BPF_H | BPF_ABS, ether_type),
    sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, ETH_P_IP, 0, 15),
    sock_filter BPF_STMT(BPF_LD | BPF_B | BPF_ABS, ip_protocol),
    sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, IPPROTO_UDP, 0, 13),
    sock_filter BPF_STMT(BPF_LD | BPF_H | BPF_ABS, ip_fragment),
    sock_filter BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, 0x1fff, 11, 0),
    sock_filter BPF_STMT(BPF_LDX | BPF_B | BPF_MSH, ip_header),  // X = length of the IP header
    sock_filter BPF_STMT(BPF_LD | BPF_B | BPF_IND, udp_payload),
    sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, first, 8, 0),
    sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, following, 7, 0),
    sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, packed, 6, 0),
    sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, whole, 5, 0),
    sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, single, 4, 0),
    sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, far, 3, 0),
    sock_filter BPF_STMT(BPF_ALU | BPF_AND | BPF_K, version_bits),
    sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, version, 0, 1),
    sock_filter BPF_STMT(BPF_RET | BPF_K, 0xffffffff),
    sock_filter BPF_STMT(BPF_RET | BPF_K, 0),
};

}  // namespace

ControlCounter::ControlCounter() {
  auto packets = open_packets(host_interface, control_only, buffer_bytes);
  if (!packets) {
    std::fprintf(stderr, "%s\n", packets.error().message.c_str());
    std::exit(1);
  }
  packets_ = std::move(*packets);
}

ControlTraffic ControlCounter::read() const {
  ControlTraffic traffic;
  char unused = 0;
  // With MSG_TRUNC, recv() returns the length of the whole frame, of which only one byte is read.
  for (ssize_t bytes = 0; (bytes = recv(packets_.get(), &unused, 1, MSG_TRUNC)) > 0;) {
    traffic.bytes += bytes;
    ++traffic.datagrams;
  }
  tpacket_stats statistics{};
  socklen_t length = sizeof statistics;
  getsockopt(packets_.get(), SOL_PACKET, PACKET_STATISTICS, &statistics, &length);
  if (statistics.tp_drops == 0) return traffic;
  std::fprintf(stderr, "%u datagrams of the control traffic were not counted\n", statistics.tp_drops);
  std::exit(1);
}

}  // namespace sft::bench
