#include "udp_transport/io/interfaces.h"

#include <arpa/inet.h>
#include <net/if.h>
#include <unistd.h>

#include <algorithm>
#include <cstring>
#include <string_view>
#include <tuple>

#include "core/platform/file_descriptor.h"
#include "core/platform/host_interfaces.h"

namespace sft::udp {

namespace {
using core::IpAddress;

constexpr int mtu_default = 1500;

/// Returns the source address that the system uses for `elsewhere`, without sending anything. Returns the
/// address "any" if there is no route.
IpAddress address_towards(const IpAddress& elsewhere) {
  const SystemAddress to({elsewhere, 9});
  const core::FileDescriptor probe(::socket(to.family(), SOCK_DGRAM | SOCK_CLOEXEC, 0));
  sockaddr_in6 from{};
  socklen_t size = sizeof from;
  const bool known = ::connect(probe.get(), to.get(), to.bytes()) == 0 &&
                     ::getsockname(probe.get(), reinterpret_cast<sockaddr*>(&from), &size) == 0;
  return known ? to_address(from).ip : IpAddress{};
}

// Addresses that no host has (RFC 5737, RFC 3849), so that only a default route leads to them.
constexpr IpAddress elsewhere_ipv4{0xC0000201};
constexpr IpAddress elsewhere_ipv6{
    IpAddress::Bytes{0x20, 0x01, 0x0d, 0xb8, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1}};

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

namespace {

bool may_be_a_name(std::string_view text) {
  return !text.empty() && text.size() < IF_NAMESIZE && text.find_first_of("/% ") == text.npos &&
         std::ranges::count(text, ':') < 2 && text.find_first_not_of("0123456789.") != text.npos;
}

/// Returns true for "fe80::1%eth0", even if there is no eth0 yet.
bool may_be_link_local(std::string_view text) {
  const std::size_t percent = text.find('%');
  if (percent == text.npos || !may_be_a_name(text.substr(percent + 1))) return false;
  const auto address = core::parse_ip_address(text.substr(0, percent));
  return address && address->is_link_local();
}

}  // namespace

Result<void> check_interfaces(const std::vector<std::string>& chosen) {
  for (const std::string& one : chosen) {
    if (!core::parse_ip_network(one) && !may_be_a_name(one) && !may_be_link_local(one)) {
      return fail(Errc::invalid_argument,
                  "'" + one + "' names no interface: give a name (eth0), an address of it (10.0.0.5, " +
                      "fe80::1%eth0), or its network (10.0.0.0/24, fd00::/64)");
    }
  }
  return {};
}

/// Returns true if the interface's folder has a subfolder of wireless devices: "phy80211" for present
/// drivers, or "wireless" for older ones.
bool is_wireless(const std::string& interface, const std::string& interfaces) {
  const std::string folder = interfaces + "/" + interface;
  return ::access((folder + "/phy80211").c_str(), F_OK) == 0 ||
         ::access((folder + "/wireless").c_str(), F_OK) == 0;
}

std::optional<std::vector<core::Link>> own_links(const std::vector<std::string>& chosen) {
  const auto interfaces = core::host_interfaces();
  if (!interfaces) return {};
  std::vector<core::Link> links;
  for (const core::HostInterface& interface : *interfaces) {
    if (!interface.up || interface.ip.is_any()) continue;
    const bool usable =
        chosen.empty() ? !interface.loopback : std::ranges::any_of(chosen, [&](const std::string& one) {
          return core::is_named(interface, one);
        });
    if (usable)
      links.push_back({interface.ip, interface.prefix_bits, interface.running, is_wireless(interface.name)});
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
  const core::FileDescriptor probe(::socket(to.family(), SOCK_DGRAM | SOCK_CLOEXEC, 0));
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
