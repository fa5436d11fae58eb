#include "tools/sft/multicast_check.h"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <ifaddrs.h>
#include <net/if.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <random>
#include <string>

#include "tools/terminal/units.h"

namespace sft::tool {

namespace {

using Clock = std::chrono::steady_clock;

// An address in the range that any program may use within a site (RFC 2365).
constexpr const char* group = "239.255.83.70";
constexpr std::chrono::milliseconds timeout{300};

struct Interface {
  std::string name;
  in_addr address{};
  unsigned index = 0;
};

std::vector<Interface> interfaces() {
  std::vector<Interface> found;
  ifaddrs* list = nullptr;
  if (getifaddrs(&list) != 0) return found;
  for (const ifaddrs* i = list; i != nullptr; i = i->ifa_next) {
    const unsigned wanted = IFF_UP | IFF_RUNNING;
    if (i->ifa_addr == nullptr || i->ifa_addr->sa_family != AF_INET || (i->ifa_flags & wanted) != wanted)
      continue;
    sockaddr_in address{};
    std::memcpy(&address, i->ifa_addr, sizeof address);
    found.push_back({i->ifa_name, address.sin_addr, if_nametoindex(i->ifa_name)});
  }
  freeifaddrs(list);
  return found;
}

/// A socket that sends datagrams to a group through an interface, and receives datagrams to this group
/// through the same interface.
class Loop {
 public:
  explicit Loop(const Interface& interface)
      : socket_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0)) {
    const ip_mreqn member{.imr_multiaddr = {inet_addr(group)},
                          .imr_address = interface.address,
                          .imr_ifindex = static_cast<int>(interface.index)};
    sockaddr_in any{};
    any.sin_family = AF_INET;
    any.sin_addr.s_addr = inet_addr(group);
    socklen_t bytes = sizeof any;
    open_ = bind(socket_, reinterpret_cast<sockaddr*>(&any), bytes) == 0 &&
            getsockname(socket_, reinterpret_cast<sockaddr*>(&any), &bytes) == 0 &&
            setsockopt(socket_, IPPROTO_IP, IP_ADD_MEMBERSHIP, &member, sizeof member) == 0 &&
            setsockopt(socket_, IPPROTO_IP, IP_MULTICAST_IF, &member, sizeof member) == 0;
    if (!open_) why_not_ = std::strerror(errno);
    to_ = any;
  }
  ~Loop() { close(socket_); }
  Loop(const Loop&) = delete;
  Loop& operator=(const Loop&) = delete;

  /// Returns an empty text if the datagram came back, otherwise the reason why it did not.
  std::string round_trip(Stop& stop) {
    if (!open_) return why_not_;
    const std::uint64_t word = std::random_device()() | std::uint64_t{std::random_device()()} << 32;
    if (sendto(socket_, &word, sizeof word, 0, reinterpret_cast<sockaddr*>(&to_), sizeof to_) < 0)
      return std::strerror(errno);
    for (const auto end = Clock::now() + timeout; Clock::now() < end;) {
      if (stop.wait_for(end - Clock::now(), socket_)) return "stopped";
      std::uint64_t read = 0;
      if (recv(socket_, &read, sizeof read, 0) == sizeof read && read == word) return {};
    }
    return "nothing came back";
  }

 private:
  int socket_;
  bool open_ = false;
  std::string why_not_;
  sockaddr_in to_{};
};

}  // namespace

std::vector<Finding> check_multicast(const std::vector<std::string>& in_use, Stop& stop) {
  std::vector<Finding> findings;
  for (const Interface& interface : interfaces()) {
    if (!in_use.empty() && std::ranges::find(in_use, interface.name) == in_use.end()) continue;
    Loop loop(interface);
    const auto begun = Clock::now();
    const std::string why_not = loop.round_trip(stop);
    const double passed = std::chrono::duration<double>(Clock::now() - begun).count();
    if (why_not.empty()) {
      findings.push_back(
          {"multicast", Health::ok,
           fmt::format("{}: a datagram came back after {}", interface.name, duration_text(passed))});
    } else {
      findings.push_back(
          {"multicast", Health::warning, fmt::format("{}: {}", interface.name, why_not),
           "Nodes do not find each other by this interface: allow multicast on it, or name hosts as "
           "peers."});
    }
  }
  if (findings.empty()) {
    findings.push_back({"multicast", Health::error,
                        "no interface in use has an IPv4 address, not even the loopback",
                        "Nodes of this host find each other by the loopback: run ip link set lo up."});
  }
  return findings;
}

}  // namespace sft::tool
