#include "core/discovery/node_claims.h"

#include <algorithm>

#include "core/discovery/leases.h"

namespace sft::core {

bool NodeClaims::asserted(NodeId id, const Speaker& speaker, std::chrono::milliseconds silence, Time now) {
  if (!nodes_.contains(id) && nodes_.size() >= nodes_max_) return false;
  Node& node = nodes_[id];
  auto own = std::ranges::find(node.claims, speaker, &Claim::speaker);
  if (own == node.claims.end()) own = node.claims.insert(own, {.speaker = speaker});
  own->heard = now;
  for (Claim& claim : node.claims) {
    if (claim.speaker == speaker) {
      claim.alive = true;
      break;
    }
    const bool is_first_of_link = claim.speaker.link == speaker.link && claim.alive;
    if (is_first_of_link && speakers_.speaks(claim.speaker, silence, now)) return false;
  }
  node.lost = false;
  node.lost_at.reset();
  return true;
}

bool NodeClaims::unheard(NodeId id, LinkId link, const LeaseOf& lease_of, Time now) {
  const auto node = nodes_.find(id);
  if (node == nodes_.end()) return false;
  for (Claim& claim : node->second.claims) claim.alive &= claim.speaker.link != link;
  return is_lost(id, node->second, lease_of, now);
}

void NodeClaims::participant_departed(const Speaker& speaker) {
  for (auto& [id, node] : nodes_) {
    for (Claim& claim : node.claims) claim.alive &= claim.speaker != speaker;
  }
}

void NodeClaims::link_dropped(LinkId link) {
  for (auto& [id, node] : nodes_) {
    for (Claim& claim : node.claims) claim.alive &= claim.speaker.link != link;
  }
}

void NodeClaims::forget_link(LinkId link) {
  for (auto& [id, node] : nodes_)
    std::erase_if(node.claims, [&](const Claim& claim) { return claim.speaker.link == link; });
}

bool NodeClaims::is_vouched_for(NodeId id, const Speaker& speaker) const {
  const auto node = nodes_.find(id);
  if (node == nodes_.end()) return false;
  const auto first = std::ranges::find_if(node->second.claims, [&](const Claim& claim) {
    return claim.alive && claim.speaker.link == speaker.link;
  });
  return first != node->second.claims.end() && first->speaker == speaker;
}

NodeClaims::Lives NodeClaims::lives() const {
  Lives lives;
  for (const auto& [id, node] : nodes_) {
    const auto speakers = std::ranges::count_if(node.claims, &Claim::alive);
    lives.living += speakers > 0 ? 1 : 0;
    lives.has_rivals |= speakers > 1;
    lives.awaits_loss |= speakers == 0 && !node.lost;
  }
  return lives;
}

std::vector<NodeId> NodeClaims::take_lost(const LeaseOf& lease_of, Time now) {
  std::vector<NodeId> lost;
  for (auto& [id, node] : nodes_) {
    if (is_lost(id, node, lease_of, now)) lost.push_back(id);
  }
  return lost;
}

bool NodeClaims::is_lost(NodeId id, Node& node, const LeaseOf& lease_of, Time now) const {
  if (node.lost || std::ranges::any_of(node.claims, &Claim::alive)) return false;
  if (!node.lost_at) {
    const std::chrono::milliseconds lease = lease_of(id);
    const Time heard = last_heard(node);
    const bool was_silent = now - heard > silence_in(lease);
    node.lost_at = was_silent ? now : heard + lease;
  }
  node.lost = now >= *node.lost_at;
  return node.lost;
}

Time NodeClaims::last_heard(const Node& node) {
  Time heard{};
  for (const Claim& claim : node.claims) heard = std::max(heard, claim.heard);
  return heard;
}

void NodeClaims::end_silent(const LeaseOf& lease_of, Time now) {
  for (auto& [id, node] : nodes_) {
    for (Claim& claim : node.claims) {
      if (!claim.alive) continue;
      const std::chrono::milliseconds lease = lease_of(id);
      const bool tells_soon = speakers_.gives_pulses(claim.speaker);
      const auto patience = tells_soon ? lease : std::max(lease, lease_default) + slack;
      if (now - claim.heard > patience) claim.alive = false;
    }
  }
}

bool NodeClaims::is_lost(NodeId id) const {
  const auto node = nodes_.find(id);
  return node != nodes_.end() && node->second.lost;
}

void NodeClaims::forget_before(Time before, const std::function<bool(NodeId)>& is_needed) {
  std::erase_if(nodes_, [&](const auto& entry) {
    const auto& [id, node] = entry;
    return node.lost && *node.lost_at <= before && !is_needed(id);
  });
}

}  // namespace sft::core
