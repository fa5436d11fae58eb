#include "core/discovery/own_announcements.h"

#include <algorithm>

#include "core/control/control_digest.h"

namespace sft::core {

const Endpoint& OwnAnnouncements::announce(const Endpoint& endpoint) {
  Own& own = own_[endpoint.id];
  const std::uint64_t revision = std::max(own.endpoint.revision + 1, endpoint.revision);
  own.endpoint = endpoint;
  own.endpoint.revision = revision;
  return own.endpoint;
}

std::optional<Role> OwnAnnouncements::withdraw(EndpointId id) {
  const auto own = own_.extract(id);
  return own ? std::optional(own.mapped().endpoint.role) : std::nullopt;
}

void OwnAnnouncements::request(const Request& request) {
  if (const auto own = own_.find(request.reader); own != own_.end()) own->second.request = request;
}

std::uint32_t OwnAnnouncements::digest(Role role) const {
  std::uint32_t digest = 0;
  for (const auto& [id, own] : own_) {
    if (own.endpoint.role != role) continue;
    const std::uint64_t asked = own.request ? own.request->sequence : 0;
    digest = add_to_digest(
        digest, digest_part(id, own.endpoint.revision, std::max(asked, own.endpoint.request.sequence)));
  }
  return digest;
}

void OwnAnnouncements::write_to(DiscoveryLink& link) const {
  for (const auto& [endpoint, own] : own_) {
    (void)link.write(own.endpoint);
    if (own.request && own.request->sequence > own.endpoint.request.sequence) (void)link.write(*own.request);
  }
}

}  // namespace sft::core
