#include "bench/udp/wire_tap.h"

#include <arpa/inet.h>
#include <linux/if_ether.h>
#include <linux/if_packet.h>
#include <net/if.h>
#include <netinet/in.h>
#include <netinet/ip.h>
#include <netinet/udp.h>
#include <sys/mman.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <ctime>
#include <optional>
#include <thread>

#include "bench/common/pair.h"
#include "tools/hosts/network.h"
#include "udp_transport/wire/datagram.h"

namespace sft::bench {

namespace {

// A frame holds the note of a packet, and its headers.
constexpr std::size_t frame_bytes = 256;
constexpr std::size_t frames = 1 << 17;
constexpr std::size_t block_bytes = 1 << 16;
constexpr std::size_t link_header_bytes = sizeof(ethhdr);
// A segment of TCP that has no more than headers with options tells only what has come. So does a small
// message of RTPS, the protocol of DDS.
constexpr std::uint32_t tcp_answer_bytes_max = 120;
constexpr std::uint32_t rtps_answer_bytes_max = 300;
constexpr std::uint16_t fragment_offset_bits = 0x1fff;

[[noreturn]] void give_up(const char* what) {
  std::perror(what);
  std::exit(1);
}

int open_tap() {
  const int tap = socket(AF_PACKET, SOCK_RAW | SOCK_CLOEXEC, htons(ETH_P_ALL));
  if (tap < 0) give_up("packet socket");
  const int version = TPACKET_V2;
  if (setsockopt(tap, SOL_PACKET, PACKET_VERSION, &version, sizeof version) != 0) give_up("TPACKET_V2");
  tpacket_req ring{};
  ring.tp_block_size = block_bytes;
  ring.tp_block_nr = frames * frame_bytes / block_bytes;
  ring.tp_frame_size = frame_bytes;
  ring.tp_frame_nr = frames;
  if (setsockopt(tap, SOL_PACKET, PACKET_RX_RING, &ring, sizeof ring) != 0) give_up("PACKET_RX_RING");
  sockaddr_ll interface {};
  interface.sll_family = AF_PACKET;
  interface.sll_protocol = htons(ETH_P_ALL);
  interface.sll_ifindex = static_cast<int>(if_nametoindex(hosts::host_interface));
  if (bind(tap, reinterpret_cast<sockaddr*>(&interface), sizeof interface) != 0)
    give_up("bind a packet socket");
  return tap;
}

/// CLOCK_REALTIME less CLOCK_MONOTONIC.
std::int64_t realtime_ahead_ns() {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  return std::int64_t{now.tv_sec} * 1'000'000'000 + now.tv_nsec - now_ns();
}

std::optional<Packet::Kind> kind_of(const std::uint8_t* bytes, std::uint32_t captured, std::uint32_t length) {
  if (captured < link_header_bytes + sizeof(iphdr)) return std::nullopt;
  const auto* ip = reinterpret_cast<const iphdr*>(bytes + link_header_bytes);
  if (ip->version != 4) return std::nullopt;
  if (ip->protocol == IPPROTO_TCP)
    return length <= tcp_answer_bytes_max ? Packet::Kind::answer : Packet::Kind::data;
  const std::size_t headers = link_header_bytes + std::size_t{ip->ihl} * 4 + sizeof(udphdr);
  if (ip->protocol != IPPROTO_UDP || captured <= headers) return std::nullopt;
  if ((ntohs(ip->frag_off) & fragment_offset_bits) != 0) return Packet::Kind::data;
  const std::uint8_t version_and_kind = bytes[headers];
  if (captured >= headers + 4 && std::memcmp(bytes + headers, "RTPS", 4) == 0)
    return length <= rtps_answer_bytes_max ? Packet::Kind::answer : Packet::Kind::data;
  if (version_and_kind >> 4 != udp::wire_version) return std::nullopt;
  const auto kind = static_cast<udp::DatagramKind>(version_and_kind & 0xf);
  return udp::is_of_sample(kind) ? Packet::Kind::data : Packet::Kind::answer;
}

}  // namespace

WireTap::WireTap(const std::function<void()>& enter) {
  std::thread([&] {
    enter();
    socket_ = open_tap();
  }).join();
  void* ring = mmap(nullptr, frames * frame_bytes, PROT_READ | PROT_WRITE, MAP_SHARED, socket_, 0);
  if (ring == MAP_FAILED) give_up("map the packets");
  ring_ = static_cast<std::uint8_t*>(ring);
}

WireTap::~WireTap() {
  munmap(ring_, frames * frame_bytes);
  close(socket_);
}

std::vector<Packet> WireTap::packets() {
  std::vector<Packet> packets;
  const std::int64_t ahead = realtime_ahead_ns();
  for (;;) {
    auto* frame = reinterpret_cast<tpacket2_hdr*>(ring_ + next_ * frame_bytes);
    const std::uint32_t status = __atomic_load_n(&frame->tp_status, __ATOMIC_ACQUIRE);
    if ((status & TP_STATUS_USER) == 0) break;
    if ((status & TP_STATUS_LOSING) != 0) lost_ = true;
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(frame) + frame->tp_mac;
    const auto* from = reinterpret_cast<const sockaddr_ll*>(reinterpret_cast<const std::uint8_t*>(frame) +
                                                            TPACKET_ALIGN(sizeof(tpacket2_hdr)));
    if (const auto kind = kind_of(bytes, frame->tp_snaplen, frame->tp_len)) {
      packets.push_back({.at_ns = std::int64_t{frame->tp_sec} * 1'000'000'000 + frame->tp_nsec - ahead,
                         .bytes = frame->tp_len,
                         .outgoing = from->sll_pkttype == PACKET_OUTGOING,
                         .kind = *kind});
    }
    __atomic_store_n(&frame->tp_status, TP_STATUS_KERNEL, __ATOMIC_RELEASE);
    next_ = (next_ + 1) % frames;
  }
  return packets;
}

}  // namespace sft::bench
