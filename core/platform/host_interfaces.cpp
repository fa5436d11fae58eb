#include "core/platform/host_interfaces.h"

#include <ifaddrs.h>
#include <linux/if_addr.h>
#include <net/if.h>
#include <netinet/in.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <memory>
#include <optional>
#include <set>
#include <system_error>
#include <utility>

namespace sft::core {

namespace {

struct IfaddrsDeleter {
  void operator()(ifaddrs* list) const { ::freeifaddrs(list); }
};

IpAddress ip_of(const sockaddr& address) noexcept {
  if (address.sa_family == AF_INET) {
    sockaddr_in ipv4{};
    std::memcpy(&ipv4, &address, sizeof ipv4);
    return ntohl(ipv4.sin_addr.s_addr);
  }
  sockaddr_in6 ipv6{};
  std::memcpy(&ipv6, &address, sizeof ipv6);
  IpAddress ip;
  std::memcpy(ip.bytes.data(), &ipv6.sin6_addr, ip.bytes.size());
  if (ip.is_link_local()) ip.scope = ipv6.sin6_scope_id;
  return ip;
}

/// Returns the prefix length of a network mask: the number of its set bits. `family` is an argument because
/// the system might not set the family of the mask.
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

/// Returns IPv6 addresses that must not be announced: temporary addresses, since their interfaces also have
/// a permanent one, and addresses that are not yet, or no longer, valid. They are read from /proc
/// (proc(5)), since getifaddrs() does not show these states.
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

/// Returns an interface whose index is not known yet.
HostInterface without_address(const ifaddrs& entry) {
  HostInterface interface;
  interface.name = entry.ifa_name;
  interface.up = (entry.ifa_flags & IFF_UP) != 0;
  interface.running = (entry.ifa_flags & IFF_RUNNING) != 0;
  interface.loopback = (entry.ifa_flags & IFF_LOOPBACK) != 0;
  interface.multicast = (entry.ifa_flags & IFF_MULTICAST) != 0;
  return interface;
}

/// Returns the interface with the address of this entry, or nothing if other hosts could not use the address.
std::optional<HostInterface> with_address(const ifaddrs& entry, const std::set<IpAddress::Bytes>& avoid) {
  if (entry.ifa_addr == nullptr || entry.ifa_netmask == nullptr) return {};
  const int family = entry.ifa_addr->sa_family;
  if (family != AF_INET && family != AF_INET6) return {};
  const IpAddress ip = ip_of(*entry.ifa_addr);
  if (avoid.contains(ip.bytes)) return {};
  HostInterface interface = without_address(entry);
  interface.ip = ip;
  interface.prefix_bits = prefix_bits(*entry.ifa_netmask, family);
  return interface;
}

/// Returns all interfaces of the list, without their indices.
std::vector<HostInterface> interfaces_in(const ifaddrs* list) {
  const std::set<IpAddress::Bytes> avoid = ipv6_addresses_to_avoid();
  std::vector<HostInterface> interfaces;
  for (const ifaddrs* i = list; i != nullptr; i = i->ifa_next) {
    if (auto interface = with_address(*i, avoid)) interfaces.push_back(std::move(*interface));
  }
  for (const ifaddrs* i = list; i != nullptr; i = i->ifa_next) {
    const std::string name = i->ifa_name;
    if (std::ranges::find(interfaces, name, &HostInterface::name) == interfaces.end())
      interfaces.push_back(without_address(*i));
  }
  return interfaces;
}

tl::unexpected<Error> not_listed(int error, const char* advice) {
  if (error == EMFILE || error == ENFILE)
    advice = ": raise the limit RLIMIT_NOFILE (ulimit -n, or LimitNOFILE= of a service)";
  return fail(Errc::unavailable, "the system does not list its network interfaces (" +
                                     std::generic_category().message(error) + ")" + advice);
}

}  // namespace

Result<std::vector<HostInterface>> host_interfaces() { return host_interfaces(::if_nametoindex); }

/// If an interface disappears before its index is found, the interfaces are listed again.
Result<std::vector<HostInterface>> host_interfaces(
    const std::function<unsigned(const char* name)>& index_of) {
  constexpr int attempts = 5;
  int error = 0;
  for (int attempt = 0; attempt < attempts; ++attempt) {
    ifaddrs* first = nullptr;
    if (::getifaddrs(&first) != 0) {
      const bool is_forbidden = errno == EAFNOSUPPORT || errno == EPERM || errno == EACCES;
      return not_listed(
          errno, is_forbidden ? ": allow sockets of AF_NETLINK (RestrictAddressFamilies= of a service)" : "");
    }
    const std::unique_ptr<ifaddrs, IfaddrsDeleter> list(first);
    std::vector<HostInterface> interfaces = interfaces_in(list.get());
    error = 0;
    for (HostInterface& interface : interfaces) {
      interface.index = index_of(interface.name.c_str());
      if (interface.index == 0) error = errno;
    }
    if (error == 0) return interfaces;
    if (error != ENODEV && error != ENXIO) break;
  }
  return not_listed(error, "");
}

bool is_named(const HostInterface& interface, const std::string& text) {
  const auto network = parse_ip_network(text);
  if (!network) return text == interface.name;
  if (interface.ip.is_any()) return false;
  if (network->prefix_bits) return in_one_network(network->ip, interface.ip, *network->prefix_bits);
  // The text is the address of the interface, or the address of its network, in which all other bits are 0.
  if (network->ip.bytes == interface.ip.bytes) return true;
  return in_one_network(network->ip, interface.ip, interface.prefix_bits) &&
         network_of(network->ip, interface.prefix_bits) == network->ip;
}

}  // namespace sft::core
