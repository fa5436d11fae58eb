#include "tools/demo/traffic.h"

#include <linux/if_ether.h>
#include <linux/if_packet.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <chrono>
#include <thread>
#include <utility>

#include "tools/hosts/interface_counters.h"
#include "tools/hosts/packet_filter.h"

namespace sft::demo {

namespace {

using namespace hosts;  // offsets in a frame

constexpr std::uint32_t rtps_magic = 0x52545053;  // "RTPS", with which all messages of DDS begin
// "SHB", with which the heartbeats of participants begin (core/discovery/heartbeat.h)
constexpr std::uint32_t heartbeat_magic = 0x53484200;

/// A filter that drops data and accepts control traffic. A frame counts as data if it is UDP over IPv4, no
/// later fragment (data is never fragmented by IP), and neither a message of DDS nor a heartbeat of a
/// participant. The last two numbers of a jump are the numbers of lines to skip: the first if the condition
/// holds, the second if it does not hold.
constexpr std::array control_only{
    sock_filter BPF_STMT(BPF_LD | BPF_H | BPF_ABS, ether_type),
    sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, ETH_P_IP, 0, 10),
    sock_filter BPF_STMT(BPF_LD | BPF_B | BPF_ABS, ip_protocol),
    sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, IPPROTO_UDP, 0, 8),
    sock_filter BPF_STMT(BPF_LD | BPF_H | BPF_ABS, ip_fragment),
    sock_filter BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, 0x1fff, 6, 0),
    sock_filter BPF_STMT(BPF_LDX | BPF_B | BPF_MSH, ip_header),  // X = length of the IP header
    sock_filter BPF_STMT(BPF_LD | BPF_W | BPF_IND, udp_payload),
    sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, rtps_magic, 3, 0),
    sock_filter BPF_STMT(BPF_ALU | BPF_AND | BPF_K, 0xffffff00),
    sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, heartbeat_magic, 1, 0),
    sock_filter BPF_STMT(BPF_RET | BPF_K, 0),
    sock_filter BPF_STMT(BPF_RET | BPF_K, 0xffffffff),
};

}  // namespace

Result<std::unique_ptr<TrafficMeter>> TrafficMeter::open(const std::string& interface) {
  return hosts::open_packets(interface, control_only).map([&](core::FileDescriptor&& packets) {
    return std::unique_ptr<TrafficMeter>(new TrafficMeter(interface, std::move(packets)));
  });
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
    // PACKET_LOOPBACK marks the copy of a multicast for this host itself. That copy was never on the
    // interface.
    if (from.sll_pkttype <= PACKET_OTHERHOST) control_bytes_ += static_cast<std::uint64_t>(bytes);
  }
}

/// The interface counts a frame a moment before the packet socket receives it. So both are read again until
/// no frame has arrived in between. If frames arrive all the time, one more or less does not matter.
std::int64_t TrafficMeter::data_bytes() {
  constexpr int tries_max = 20;
  constexpr std::chrono::milliseconds moment{1};
  const core::Lock lock(mutex_);
  std::uint64_t received = 0;
  for (int tries = 0; tries < tries_max; ++tries) {
    const auto now = hosts::interface_bytes(interface_).value_or(InterfaceBytes{}).received;
    if (tries > 0 && now == received) break;
    received = now;
    std::this_thread::sleep_for(moment);
    count_control();
  }
  return static_cast<std::int64_t>(received - control_bytes_);
}

}  // namespace sft::demo
