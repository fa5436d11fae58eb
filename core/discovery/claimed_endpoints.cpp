#include "core/discovery/claimed_endpoints.h"

namespace sft::core {

EndpointClaims* ClaimedEndpoints::find(EndpointId id) {
  const auto known = endpoints_.find(id);
  return known == endpoints_.end() ? nullptr : &known->second;
}

void ClaimedEndpoints::forget_before(Time before) {
  for (auto known = endpoints_.begin(); known != endpoints_.end();)
    known = known->second.forget_before(before) ? endpoints_.erase(known) : std::next(known);
  std::erase_if(by_node_, [&](const auto& entry) { return !is_claimed(entry.second, entry.first); });
}

bool ClaimedEndpoints::is_claimed(EndpointId id, NodeId node) {
  const Endpoint* const told = this->told(id);
  bool is_claimed = told != nullptr && told->node_id == node;
  if (const EndpointClaims* const claims = find(id))
    claims->each_alive([&](const Claim& claim) { is_claimed |= claim.endpoint->node_id == node; });
  return is_claimed;
}

const Endpoint* ClaimedEndpoints::told(EndpointId id) const {
  const auto known = endpoints_.find(id);
  return known == endpoints_.end() ? nullptr : known->second.told().endpoint();
}

const Endpoint* ClaimedEndpoints::some_told_of(NodeId node) const {
  const Endpoint* some = nullptr;
  each_told_of(node, [&](const Endpoint& one) {
    some = &one;
    return false;
  });
  return some;
}

}  // namespace sft::core
