#include "udp_transport/io/group_joins.h"

#include <netinet/in.h>

#include <algorithm>

#include "core/platform/ip_address.h"
#include "udp_transport/io/interfaces.h"

namespace sft::udp {

namespace {

/// Returns the address of this host on the route to `to`; empty if there is no IPv4 route.
core::IpAddress own_address_towards(const SocketAddress& to) noexcept {
  if (!to.ip.is_ipv4()) return {};
  const FileDescriptor probe(::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0));
  const SystemAddress there(to);
  sockaddr_in6 own{};
  socklen_t size = sizeof own;
  const bool known = ::connect(probe.get(), there.get(), there.bytes()) == 0 &&
                     ::getsockname(probe.get(), reinterpret_cast<sockaddr*>(&own), &size) == 0;
  return known ? to_address(own).ip : core::IpAddress{};
}

}  // namespace

void GroupJoins::set(int option, const Joined& joined) noexcept {
  if (!socket_->groups.group_fd) return;
  const ip_mreq request{.imr_multiaddr = {htonl(joined.group)}, .imr_interface = {htonl(joined.own)}};
  ::setsockopt(socket_->groups.group_fd.get(), IPPROTO_IP, option, &request, sizeof request);
}

void GroupJoins::join(std::uint32_t group, const SocketAddress& towards, bool anew) noexcept {
  const core::IpAddress own = own_address_towards(towards);
  if (!own.is_ipv4()) return;
  const Joined wanted{group, own.ipv4()};
  if (const auto known = std::ranges::find(joined_, wanted); known != joined_.end()) {
    if (anew) set(IP_DROP_MEMBERSHIP, wanted);
    if (anew) set(IP_ADD_MEMBERSHIP, wanted);
    return;
  }
  if (joined_.size() == joins_max) return;
  set(IP_ADD_MEMBERSHIP, wanted);
  socket_->in_groups.store(true, std::memory_order_relaxed);
  joined_.push_back(wanted);
}

void GroupJoins::keep_to(std::span<const std::uint32_t> groups) noexcept {
  std::erase_if(joined_, [&](const Joined& joined) {
    if (std::ranges::find(groups, joined.group) != groups.end()) return false;
    set(IP_DROP_MEMBERSHIP, joined);
    return true;
  });
  socket_->in_groups.store(!joined_.empty(), std::memory_order_relaxed);
}

}  // namespace sft::udp
