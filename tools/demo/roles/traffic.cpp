#include "tools/demo/roles/traffic.h"

#include <linux/if_ether.h>
#include <linux/if_packet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <thread>
#include <utility>

#include "tools/hosts/interface_counters.h"
#include "tools/hosts/packet_filter.h"

namespace sft::demo {

namespace {

using namespace hosts;  // offsets in a frame

/// Drops data, which is UDP over IPv4 and not a later fragment (data is never fragmented by IP). A datagram
/// of data begins with a small number, its version and kind; those of discovery begin with a capital letter.
/// The last two numbers of a jump tell how many lines to skip if the condition holds, and if it does not.
constexpr std::array control_only{
    sock_filter BPF_STMT(BPF_LD | BPF_H | BPF_ABS, ether_type),
    sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, ETH_P_IP, 0, 8),
    sock_filter BPF_STMT(BPF_LD | BPF_B | BPF_ABS, ip_protocol),
    sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, IPPROTO_UDP, 0, 6),
    sock_filter BPF_STMT(BPF_LD | BPF_H | BPF_ABS, ip_fragment),
    sock_filter BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, 0x1fff, 4, 0),
    sock_filter BPF_STMT(BPF_LDX | BPF_B | BPF_MSH, ip_header),  // X = length of the IP header
    sock_filter BPF_STMT(BPF_LD | BPF_B | BPF_IND, udp_payload),
    sock_filter BPF_JUMP(BPF_JMP | BPF_JGE | BPF_K, 'A', 1, 0),
    sock_filter BPF_STMT(BPF_RET | BPF_K, 0),
    sock_filter BPF_STMT(BPF_RET | BPF_K, 0xffffffff),
};

}  // namespace

Result<std::unique_ptr<TrafficMeter>> TrafficMeter::open(const std::string& interface) {
  return hosts::open_packets(interface, control_only).map([&](core::FileDescriptor&& packets) {
    return std::unique_ptr<TrafficMeter>(new TrafficMeter(interface, std::move(packets)));
  });
}

TrafficMeter::TrafficMeter(std::string interface, core::FileDescriptor packets)
    : interface_(std::move(interface)), packets_(std::move(packets)) {
  const std::int64_t before = data_received();
  const core::Lock lock(mutex_);
  not_data_ += before;
}

void TrafficMeter::count_control() {
  for (;;) {
    char unused = 0;
    sockaddr_ll from{};
    socklen_t from_bytes = sizeof from;
    // MSG_TRUNC returns the length of the packet, of which one byte is read.
    const ssize_t bytes =
        recvfrom(packets_.get(), &unused, 1, MSG_TRUNC, reinterpret_cast<sockaddr*>(&from), &from_bytes);
    if (bytes < 0 && errno == EINTR) continue;
    if (bytes < 0) return;
    // PACKET_LOOPBACK marks this host's own copy of a multicast, which never was on the interface.
    if (from.sll_pkttype <= PACKET_OTHERHOST) not_data_ += bytes;
  }
}

/// A frame is counted by the interface first, and a moment later it comes to the packet socket. So both are
/// read again until no frame has come meanwhile; while many come, one more or less does not count.
std::int64_t TrafficMeter::data_received() {
  constexpr int tries_max = 20;
  constexpr std::chrono::milliseconds moment{1};
  const auto counter = [this] { return interface_bytes(interface_).value_or(InterfaceBytes{}).received; };
  std::int64_t data = 0;
  std::uint64_t bytes = counter();
  for (int tries = 0; tries < tries_max; ++tries) {
    std::this_thread::sleep_for(moment);
    const core::Lock lock(mutex_);
    count_control();
    data = static_cast<std::int64_t>(bytes) - not_data_;
    const std::uint64_t now = counter();
    const bool is_quiet = now == std::exchange(bytes, now);
    if (is_quiet) break;
  }
  return data;
}

}  // namespace sft::demo
