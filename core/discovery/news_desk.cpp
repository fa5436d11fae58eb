#include "core/discovery/news_desk.h"

#include <algorithm>
#include <utility>

#include "core/control/described_type.h"

namespace sft::core {

void NewsDesk::operator()(const EndpointSeen& seen) const {
  Endpoint endpoint = *seen.endpoint;
  if (!endpoint.type_description.empty()) {
    if (const auto type = described_type(endpoint); !type) {
      (*this)(Refused{type.error().message});
      endpoint.type_description.clear();
    }
  }
  leave_out_what_is_cut(endpoint, seen.silent);
  tell([&](DiscoveryListener& listener) { listener.endpoint_seen(endpoint); });
}

/// Keeps an address in any case.
void NewsDesk::leave_out_what_is_cut(Endpoint& endpoint, const std::vector<LinkId>& silent) const {
  const auto is_cut = [&](const UdpAddress& address) {
    return std::ranges::any_of(silent, [&](LinkId id) {
      const auto link = links_.find(id);
      return link != links_.end() && leads_to(link->second, address.ip);
    });
  };
  if (std::ranges::all_of(endpoint.addresses, is_cut)) return;
  std::erase_if(endpoint.addresses, is_cut);
}

}  // namespace sft::core
