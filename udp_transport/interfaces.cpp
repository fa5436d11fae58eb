#include "udp_transport/interfaces.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <sys/socket.h>

#include <algorithm>

#include "udp_transport/datagram.h"
#include "udp_transport/udp_socket.h"

namespace sft::udp {

namespace {
constexpr int ip_and_udp_header_bytes = 28;
constexpr int mtu_default = 1500;

/// Where the default route leaves the host, rather than the bridge of
/// some container; 0 without one. Sends nothing.
std::uint32_t address_towards_others() {
  constexpr std::uint32_t elsewhere = 0xC0000201;  // 192.0.2.1, which is nobody's
  const FileDescriptor probe(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  const sockaddr_in to = to_sockaddr({elsewhere, 9});
  sockaddr_in from{};
  socklen_t size = sizeof from;
  const bool known = ::connect(probe.get(), reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0 &&
                     ::getsockname(probe.get(), reinterpret_cast<sockaddr*>(&from), &size) == 0;
  return known ? to_address(from).ipv4 : 0;
}

std::uint32_t ipv4_of(const sockaddr& address) {
  return to_address(reinterpret_cast<const sockaddr_in&>(address)).ipv4;
}

bool is_chosen(std::string_view name, const core::Link& link, const std::vector<std::string>& chosen) {
  return std::ranges::any_of(chosen, [&](const std::string& one) {
    in_addr address{};
    if (::inet_pton(AF_INET, one.c_str(), &address) != 1) return one == name;
    const std::uint32_t ipv4 = ntohl(address.s_addr);
    return ipv4 == link.ipv4 || ipv4 == (link.ipv4 & link.netmask);
  });
}

}  // namespace

sockaddr_in to_sockaddr(const SocketAddress& address) noexcept {
  sockaddr_in s{};
  s.sin_family = AF_INET;
  s.sin_port = htons(address.port);
  s.sin_addr.s_addr = htonl(address.ipv4);
  return s;
}

SocketAddress to_address(const sockaddr_in& address) noexcept {
  return {.ipv4 = ntohl(address.sin_addr.s_addr), .port = ntohs(address.sin_port)};
}

std::string format_ipv4(std::uint32_t ipv4) {
  const in_addr address{htonl(ipv4)};
  char text[INET_ADDRSTRLEN] = "";
  ::inet_ntop(AF_INET, &address, text, sizeof text);
  return text;
}

std::vector<core::Link> own_links(const std::vector<std::string>& chosen) {
  std::vector<core::Link> links, without_carrier;
  ifaddrs* list = nullptr;
  if (::getifaddrs(&list) == 0) {
    for (const ifaddrs* i = list; i != nullptr; i = i->ifa_next) {
      const bool has_address =
          i->ifa_addr != nullptr && i->ifa_addr->sa_family == AF_INET && i->ifa_netmask != nullptr;
      if ((i->ifa_flags & IFF_UP) == 0 || !has_address) continue;
      const core::Link link{ipv4_of(*i->ifa_addr), ipv4_of(*i->ifa_netmask)};
      const bool usable =
          chosen.empty() ? (i->ifa_flags & IFF_LOOPBACK) == 0 : is_chosen(i->ifa_name, link, chosen);
      if (usable) ((i->ifa_flags & IFF_RUNNING) != 0 ? links : without_carrier).push_back(link);
    }
    ::freeifaddrs(list);
  }
  const std::uint32_t preferred = address_towards_others();
  std::stable_partition(links.begin(), links.end(), [&](const core::Link& l) { return l.ipv4 == preferred; });
  links.insert(links.end(), without_carrier.begin(), without_carrier.end());
  if (links.empty() && chosen.empty()) links.push_back({INADDR_LOOPBACK, IN_CLASSA_NET});
  return links;
}

std::uint16_t datagram_bytes_to(const SocketAddress& address) noexcept {
  const FileDescriptor probe(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  const sockaddr_in to = to_sockaddr(address);
  int mtu = 0;
  socklen_t size = sizeof mtu;
  const bool known = ::connect(probe.get(), reinterpret_cast<const sockaddr*>(&to), sizeof to) == 0 &&
                     ::getsockopt(probe.get(), IPPROTO_IP, IP_MTU, &mtu, &size) == 0;
  const int payload = (known ? mtu : mtu_default) - ip_and_udp_header_bytes;
  return static_cast<std::uint16_t>(std::clamp<int>(payload, datagram_bytes_min, datagram_bytes_max));
}

}  // namespace sft::udp
