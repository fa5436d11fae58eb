#include "core/platform/ip_address.h"

#include <arpa/inet.h>
#include <net/if.h>

#include <algorithm>
#include <charconv>
#include <cstring>

namespace sft::core {

namespace {

constexpr unsigned mapped_prefix_bits = 96;

template <class Number>
std::optional<Number> parse_number(std::string_view text) {
  Number number = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  return error == std::errc{} && end == text.data() + text.size() ? std::optional(number) : std::nullopt;
}

std::string name_of_interface(std::uint32_t index) {
  char name[IF_NAMESIZE] = "";
  return ::if_indextoname(index, name) != nullptr ? name : std::to_string(index);
}

std::optional<std::uint32_t> index_of_interface(std::string_view name) {
  const std::uint32_t index = ::if_nametoindex(std::string(name).c_str());
  return index != 0 ? index : parse_number<std::uint32_t>(name);
}

}  // namespace

IpAddress network_of(const IpAddress& address, unsigned prefix_bits) {
  IpAddress network = address;
  unsigned bits = prefix_bits + (address.is_ipv4() ? mapped_prefix_bits : 0);
  for (std::uint8_t& byte : network.bytes) {
    const unsigned kept = std::min(bits, 8U);
    byte &= static_cast<std::uint8_t>(0xff00U >> kept);
    bits -= kept;
  }
  return network;
}

bool in_one_network(const IpAddress& a, const IpAddress& b, unsigned prefix_bits) {
  if (a.is_ipv4() != b.is_ipv4()) return false;
  if (a.scope != b.scope && a.scope != 0 && b.scope != 0) return false;
  return network_of(a, prefix_bits).bytes == network_of(b, prefix_bits).bytes;
}

std::string format(const IpAddress& address) {
  char text[INET6_ADDRSTRLEN] = "";
  const void* bytes = address.is_ipv4() ? address.bytes.data() + 12 : address.bytes.data();
  ::inet_ntop(address.is_ipv4() ? AF_INET : AF_INET6, bytes, text, sizeof text);
  return address.scope == 0 ? text : text + ("%" + name_of_interface(address.scope));
}

std::string format(const IpAddress& address, std::uint16_t port) {
  const std::string host = format(address);
  return (address.is_ipv4() ? host : "[" + host + "]") + ":" + std::to_string(port);
}

std::optional<IpAddress> parse_ip_address(std::string_view text) {
  const std::size_t scope_at = std::min(text.find('%'), text.size());
  const std::string host(text.substr(0, scope_at));
  in_addr ipv4{};
  if (::inet_pton(AF_INET, host.c_str(), &ipv4) == 1)
    return scope_at == text.size() ? std::optional<IpAddress>(ntohl(ipv4.s_addr)) : std::nullopt;
  in6_addr ipv6{};
  if (::inet_pton(AF_INET6, host.c_str(), &ipv6) != 1) return std::nullopt;
  IpAddress address;
  std::memcpy(address.bytes.data(), &ipv6, sizeof ipv6);
  if (scope_at == text.size()) return address;
  const auto scope = index_of_interface(text.substr(scope_at + 1));
  if (!scope || !address.is_link_local()) return std::nullopt;
  address.scope = *scope;
  return address;
}

std::optional<IpNetwork> parse_ip_network(std::string_view text) {
  const std::size_t slash = std::min(text.find('/'), text.size());
  const std::optional<IpAddress> ip = parse_ip_address(text.substr(0, slash));
  if (!ip) return std::nullopt;
  if (slash == text.size()) return IpNetwork{*ip, {}};
  const auto bits = parse_number<unsigned>(text.substr(slash + 1));
  if (!bits || *bits > (ip->is_ipv4() ? 32U : 128U)) return std::nullopt;
  return IpNetwork{*ip, bits};
}

}  // namespace sft::core
