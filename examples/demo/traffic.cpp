#include "examples/demo/traffic.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <linux/filter.h>
#include <linux/if_ether.h>
#include <linux/if_packet.h>
#include <net/if.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <iterator>
#include <sstream>

namespace sft::demo {

namespace {

// Offsets in an Ethernet frame, and in the IPv4 packet in it.
constexpr std::uint32_t ether_type = 12;
constexpr std::uint32_t ip_header = 14;
constexpr std::uint32_t ip_fragment = ip_header + 6;
constexpr std::uint32_t ip_protocol = ip_header + 9;
constexpr std::uint32_t udp_payload = ip_header + 8;  // behind the IP header
constexpr std::uint32_t rtps_magic = 0x52545053;      // "RTPS", with which all messages of DDS begin

/// Drops what is data: UDP over IPv4, not a later fragment (data is never fragmented by IP), and not DDS. The
/// last two figures of a jump are how many lines to skip if the condition holds and if not.
constexpr std::array control_only{
    sock_filter BPF_STMT(BPF_LD | BPF_H | BPF_ABS, ether_type),
    sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, ETH_P_IP, 0, 8),
    sock_filter BPF_STMT(BPF_LD | BPF_B | BPF_ABS, ip_protocol),
    sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, IPPROTO_UDP, 0, 6),
    sock_filter BPF_STMT(BPF_LD | BPF_H | BPF_ABS, ip_fragment),
    sock_filter BPF_JUMP(BPF_JMP | BPF_JSET | BPF_K, 0x1fff, 4, 0),
    sock_filter BPF_STMT(BPF_LDX | BPF_B | BPF_MSH, ip_header),  // X = length of the IP header
    sock_filter BPF_STMT(BPF_LD | BPF_W | BPF_IND, udp_payload),
    sock_filter BPF_JUMP(BPF_JMP | BPF_JEQ | BPF_K, rtps_magic, 1, 0),
    sock_filter BPF_STMT(BPF_RET | BPF_K, 0),
    sock_filter BPF_STMT(BPF_RET | BPF_K, 0xffffffff),
};

tl::unexpected<Error> system_error(const std::string& interface) {
  const Errc code = errno == EPERM || errno == EACCES ? Errc::no_permission : Errc::system;
  return fail(code, fmt::format("the traffic of {} cannot be counted: {}", interface, std::strerror(errno)));
}

}  // namespace

Traffic operator-(const Traffic& after, const Traffic& before) {
  return {after.at_ns - before.at_ns, after.received - before.received, after.sent - before.sent,
          after.control_received - before.control_received, after.control_sent - before.control_sent};
}

bool parse_counters(const std::string& text, const std::string& interface, Traffic& traffic) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t colon = line.find(':');
    const std::size_t begin = line.find_first_not_of(' ');
    if (colon == std::string::npos || line.substr(begin, colon - begin) != interface) continue;
    std::istringstream figures(line.substr(colon + 1));
    std::uint64_t skipped = 0;
    figures >> traffic.received;
    for (int i = 0; i < 7; ++i)
      figures >> skipped;  // packets, errs, drop, fifo, frame, compressed, multicast
    figures >> traffic.sent;
    return !figures.fail();
  }
  return false;
}

Result<std::unique_ptr<TrafficMeter>> TrafficMeter::open(const std::string& interface) {
  // Bound to its interface, and to all protocols, only once the filter is in place.
  Descriptor packets(socket(AF_PACKET, SOCK_RAW | SOCK_CLOEXEC | SOCK_NONBLOCK, 0));
  if (!packets) return system_error(interface);
  const sock_fprog filter{.len = control_only.size(),
                          .filter = const_cast<sock_filter*>(control_only.data())};
  if (setsockopt(packets.get(), SOL_SOCKET, SO_ATTACH_FILTER, &filter, sizeof filter) != 0) {
    return system_error(interface);
  }
  sockaddr_ll address{};
  address.sll_family = AF_PACKET;
  address.sll_protocol = htons(ETH_P_ALL);
  address.sll_ifindex = static_cast<int>(if_nametoindex(interface.c_str()));
  if (address.sll_ifindex == 0) return system_error(interface);
  if (bind(packets.get(), reinterpret_cast<const sockaddr*>(&address), sizeof address) != 0) {
    return system_error(interface);
  }
  return std::unique_ptr<TrafficMeter>(new TrafficMeter(interface, std::move(packets)));
}

void TrafficMeter::count_control() {
  for (;;) {
    char unused = 0;
    sockaddr_ll from{};
    socklen_t from_bytes = sizeof from;
    // MSG_TRUNC: the length of the packet, of which a byte is enough.
    const ssize_t bytes =
        recvfrom(packets_.get(), &unused, 1, MSG_TRUNC, reinterpret_cast<sockaddr*>(&from), &from_bytes);
    if (bytes < 0 && errno == EINTR) continue;
    if (bytes < 0) return;
    if (from.sll_pkttype == PACKET_OUTGOING) control_sent_ += static_cast<std::uint64_t>(bytes);
    // PACKET_LOOPBACK is the own copy of a multicast: it never was on the interface.
    if (from.sll_pkttype <= PACKET_OTHERHOST) control_received_ += static_cast<std::uint64_t>(bytes);
  }
}

Traffic TrafficMeter::read() {
  const std::scoped_lock lock(mutex_);
  std::ifstream file("/proc/net/dev");
  const std::string text(std::istreambuf_iterator<char>(file), {});
  Traffic traffic;
  parse_counters(text, interface_, traffic);
  count_control();
  traffic.control_received = control_received_;
  traffic.control_sent = control_sent_;
  traffic.at_ns = std::chrono::steady_clock::now().time_since_epoch().count();
  return traffic;
}

}  // namespace sft::demo
