#include "udp_transport/interfaces.h"

#include <arpa/inet.h>
#include <ifaddrs.h>
#include <linux/if_addr.h>
#include <net/if.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cstring>
#include <fstream>
#include <memory>
#include <optional>
#include <set>
#include <string_view>
#include <tuple>

#include "udp_transport/udp_socket.h"

namespace sft::udp {

namespace {
using core::IpAddress;

constexpr int mtu_default = 1500;

/// From where the default route leaves the host, rather than the bridge of some container; any without one.
/// Sends nothing.
IpAddress address_towards(const IpAddress& elsewhere) {
  const SystemAddress to({elsewhere, 9});
  const FileDescriptor probe(::socket(to.family(), SOCK_DGRAM | SOCK_CLOEXEC, 0));
  sockaddr_in6 from{};
  socklen_t size = sizeof from;
  const bool known = ::connect(probe.get(), to.get(), to.bytes()) == 0 &&
                     ::getsockname(probe.get(), reinterpret_cast<sockaddr*>(&from), &size) == 0;
  return known ? to_address(from).ip : IpAddress{};
}

// Of these nobody has any: RFC 5737, RFC 3849.
constexpr IpAddress elsewhere_ipv4{0xC0000201};
constexpr IpAddress elsewhere_ipv6{
    IpAddress::Bytes{0x20, 0x01, 0x0d, 0xb8, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1}};

SocketAddress address_in(const sockaddr& address) noexcept {
  sockaddr_in6 copy{};
  std::memcpy(&copy, &address, address.sa_family == AF_INET6 ? sizeof copy : sizeof(sockaddr_in));
  return to_address(copy);
}

/// Set bits, since it is a mask. (Its family may be left out.)
std::uint8_t prefix_bits(const sockaddr& netmask, int family) noexcept {
  std::array<std::uint8_t, sizeof(sockaddr_in6)> bytes{};
  const std::size_t begin =
      family == AF_INET ? offsetof(sockaddr_in, sin_addr) : offsetof(sockaddr_in6, sin6_addr);
  const std::size_t end = begin + (family == AF_INET ? sizeof(in_addr) : sizeof(in6_addr));
  std::memcpy(bytes.data(), &netmask, end);
  int bits = 0;
  for (std::size_t i = begin; i < end; ++i) bits += std::popcount(bytes[i]);
  return static_cast<std::uint8_t>(bits);
}

/// IPv6 addresses that are not to be announced: temporary ones, of which there is a lasting one too, and such
/// as are not yet or no more in use. As the system lists them (proc(5)), which getifaddrs() does not tell.
std::set<IpAddress::Bytes> ipv6_addresses_to_avoid() {
  constexpr unsigned unfit = IFA_F_TEMPORARY | IFA_F_TENTATIVE | IFA_F_DADFAILED | IFA_F_DEPRECATED;
  std::set<IpAddress::Bytes> avoid;
  std::ifstream list("/proc/thread-self/net/if_inet6");
  std::string address, index, bits, scope, flags, name;
  while (list >> address >> index >> bits >> scope >> flags >> name) {
    unsigned value = 0;
    std::from_chars(flags.data(), flags.data() + flags.size(), value, 16);
    if ((value & unfit) == 0 || (value & IFA_F_OPTIMISTIC) != 0 || address.size() != 32) continue;
    IpAddress::Bytes bytes{};
    for (std::size_t i = 0; i < bytes.size(); ++i)
      std::from_chars(&address[2 * i], &address[2 * i] + 2, bytes[i], 16);
    avoid.insert(bytes);
  }
  return avoid;
}

bool is_chosen(std::string_view name, const core::Link& link, const std::vector<std::string>& chosen) {
  return std::ranges::any_of(chosen, [&](const std::string& one) {
    const auto network = core::parse_ip_network(one);
    if (!network) return one == name;
    if (network->prefix_bits) return core::in_one_network(network->ip, link.ip, *network->prefix_bits);
    // Its own address, or its network's, of which all other bits are 0.
    if (network->ip.bytes == link.ip.bytes) return true;
    return core::in_one_network(network->ip, link.ip, link.prefix_bits) &&
           core::network_of(network->ip, link.prefix_bits) == network->ip;
  });
}

struct IfaddrsDeleter {
  void operator()(ifaddrs* list) const { ::freeifaddrs(list); }
};

/// Empty where it has no address that others could use.
std::optional<core::Link> link_of(const ifaddrs& entry, const std::set<IpAddress::Bytes>& avoid) {
  if ((entry.ifa_flags & IFF_UP) == 0 || entry.ifa_addr == nullptr || entry.ifa_netmask == nullptr) return {};
  const int family = entry.ifa_addr->sa_family;
  if (family != AF_INET && family != AF_INET6) return {};
  const IpAddress ip = address_in(*entry.ifa_addr).ip;
  if (avoid.contains(ip.bytes)) return {};
  return core::Link{ip, prefix_bits(*entry.ifa_netmask, family), (entry.ifa_flags & IFF_RUNNING) != 0,
                    is_wireless(entry.ifa_name)};
}

}  // namespace

SystemAddress::SystemAddress(const SocketAddress& address, int family_of_any) noexcept
    : SystemAddress(for_socket(address, address.ip.is_any()    ? family_of_any
                                        : address.ip.is_ipv4() ? AF_INET
                                                               : AF_INET6)) {}

SystemAddress SystemAddress::for_socket(const SocketAddress& address, int family) noexcept {
  SystemAddress result;
  if (family == AF_INET && (address.ip.is_ipv4() || address.ip.is_any())) {
    sockaddr_in s{};
    s.sin_family = AF_INET;
    s.sin_port = htons(address.port);
    s.sin_addr.s_addr = htonl(address.ip.ipv4());
    std::memcpy(&result.storage_, &s, sizeof s);
  } else {
    result.storage_.sin6_family = AF_INET6;
    result.storage_.sin6_port = htons(address.port);
    result.storage_.sin6_scope_id = address.ip.scope;
    std::memcpy(&result.storage_.sin6_addr, address.ip.bytes.data(), address.ip.bytes.size());
  }
  return result;
}

SocketAddress to_address(const sockaddr_in6& of_either_family) noexcept {
  if (of_either_family.sin6_family == AF_INET) {
    sockaddr_in s{};
    std::memcpy(&s, &of_either_family, sizeof s);
    return {.ip = ntohl(s.sin_addr.s_addr), .port = ntohs(s.sin_port)};
  }
  SocketAddress address{.ip = {}, .port = ntohs(of_either_family.sin6_port)};
  std::memcpy(address.ip.bytes.data(), &of_either_family.sin6_addr, address.ip.bytes.size());
  if (address.ip.is_link_local()) address.ip.scope = of_either_family.sin6_scope_id;
  return address;
}

Result<void> check_interfaces(const std::vector<std::string>& chosen) {
  for (const std::string& one : chosen) {
    if (core::parse_ip_network(one)) continue;
    const bool is_name = !one.empty() && one.size() < IF_NAMESIZE && one.find_first_of("/% ") == one.npos &&
                         std::ranges::count(one, ':') < 2 && one.find_first_not_of("0123456789.") != one.npos;
    if (!is_name) {
      return fail(Errc::invalid_argument,
                  "'" + one + "' names no interface: give a name (eth0), an address of it (10.0.0.5, " +
                      "fe80::1%eth0), or its network (10.0.0.0/24, fd00::/64)");
    }
  }
  return {};
}

/// The first is what drivers of today have, the second those of before.
bool is_wireless(const std::string& interface, const std::string& interfaces) {
  const std::string folder = interfaces + "/" + interface;
  return ::access((folder + "/phy80211").c_str(), F_OK) == 0 ||
         ::access((folder + "/wireless").c_str(), F_OK) == 0;
}

std::vector<core::Link> own_links(const std::vector<std::string>& chosen) {
  ifaddrs* first = nullptr;
  ::getifaddrs(&first);
  const std::unique_ptr<ifaddrs, IfaddrsDeleter> list(first);
  const std::set<IpAddress::Bytes> avoid = ipv6_addresses_to_avoid();
  std::vector<core::Link> links;
  for (const ifaddrs* i = list.get(); i != nullptr; i = i->ifa_next) {
    const std::optional<core::Link> link = link_of(*i, avoid);
    if (!link) continue;
    const bool usable =
        chosen.empty() ? (i->ifa_flags & IFF_LOOPBACK) == 0 : is_chosen(i->ifa_name, *link, chosen);
    if (usable) links.push_back(*link);
  }
  const IpAddress preferred[] = {address_towards(elsewhere_ipv4), address_towards(elsewhere_ipv6)};
  std::ranges::stable_sort(links, {}, [&](const core::Link& link) {
    const bool leads_out = std::ranges::find(preferred, link.ip) != std::end(preferred);
    return std::tuple(!link.running, link.ip.is_link_local(), !leads_out, !link.ip.is_ipv4());
  });
  if (links.empty() && chosen.empty()) links.push_back({core::loopback_ipv4, 8});
  return links;
}

std::uint16_t datagram_bytes_to(const SocketAddress& address) noexcept {
  const SystemAddress to(address);
  const FileDescriptor probe(::socket(to.family(), SOCK_DGRAM | SOCK_CLOEXEC, 0));
  int mtu = 0;
  socklen_t size = sizeof mtu;
  const bool ipv4 = to.family() == AF_INET;
  const bool known =
      ::connect(probe.get(), to.get(), to.bytes()) == 0 &&
      ::getsockopt(probe.get(), ipv4 ? IPPROTO_IP : IPPROTO_IPV6, ipv4 ? IP_MTU : IPV6_MTU, &mtu, &size) == 0;
  const int payload = (known ? mtu : mtu_default) - static_cast<int>(headers_before_datagram(address.ip));
  return static_cast<std::uint16_t>(std::clamp<int>(
      payload, static_cast<int>(datagram_bytes_of_every_path(address.ip)), datagram_bytes_max));
}

}  // namespace sft::udp
