#include "core/platform/host_lookup.h"

#include <netdb.h>
#include <netinet/in.h>
#include <sys/socket.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <memory>

namespace sft::core {

namespace {

IpAddress address_in(const addrinfo& found) {
  if (found.ai_family == AF_INET) {
    sockaddr_in ipv4{};
    std::memcpy(&ipv4, found.ai_addr, sizeof ipv4);
    return {ntohl(ipv4.sin_addr.s_addr)};
  }
  sockaddr_in6 ipv6{};
  std::memcpy(&ipv6, found.ai_addr, sizeof ipv6);
  IpAddress::Bytes bytes{};
  std::memcpy(bytes.data(), &ipv6.sin6_addr, bytes.size());
  return IpAddress(bytes, ipv6.sin6_scope_id);
}

}  // namespace

Result<std::vector<IpAddress>> addresses_of_host(const std::string& name, IpFamily family) {
  addrinfo wanted{};
  wanted.ai_family = family == IpFamily::ipv4 ? AF_INET : AF_INET6;
  wanted.ai_socktype = SOCK_DGRAM;
  addrinfo* first = nullptr;
  const int error = ::getaddrinfo(name.c_str(), nullptr, &wanted, &first);
  if (error != 0)
    return fail(Errc::unavailable, error == EAI_SYSTEM ? std::strerror(errno) : ::gai_strerror(error));
  const std::unique_ptr<addrinfo, void (*)(addrinfo*)> all(first, &::freeaddrinfo);
  std::vector<IpAddress> addresses;
  for (const addrinfo* found = first; found != nullptr; found = found->ai_next) {
    if (found->ai_family == wanted.ai_family) addresses.push_back(address_in(*found));
  }
  std::ranges::sort(addresses);
  addresses.erase(std::ranges::unique(addresses).begin(), addresses.end());
  return addresses;
}

}  // namespace sft::core
