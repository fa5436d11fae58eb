#include "core/discovery/link_merge.h"

#include <algorithm>
#include <utility>

#include "core/control/control_digest.h"

namespace sft::core {

namespace {

using std::chrono::milliseconds;
constexpr milliseconds lease_default{5000};
constexpr milliseconds lease_max{60'000};
constexpr std::size_t early_requests_of_a_reader = 4;

/// Two signs of life may get lost before a speaker counts as silent: they come seven times in a lease.
milliseconds silence_in(milliseconds lease) {
  return std::clamp(lease * 3 / 10, milliseconds(300), milliseconds(4500));
}

bool say_the_same(const Endpoint& a, Endpoint b) {
  b.announcer = a.announcer;
  b.request.announcer = a.request.announcer;
  return a == b;
}

std::string name_of(const Endpoint& endpoint) {
  return "of topic '" + endpoint.topic + "' of node '" + endpoint.node + "'";
}

}  // namespace

milliseconds LinkMerge::lease_of(const Known& known) {
  return known.told == nullptr ? lease_default : std::min(known.told->life_lease, lease_max);
}

milliseconds LinkMerge::lease_of(NodeId node) const {
  const auto found = std::ranges::find_if(endpoints_, [&](const auto& entry) {
    return entry.second.told != nullptr && entry.second.told->node_id == node;
  });
  return found == endpoints_.end() ? lease_default : lease_of(found->second);
}

std::string LinkMerge::node_name(NodeId node) const {
  for (const auto& [id, known] : endpoints_) {
    if (known.told != nullptr && known.told->node_id == node) return known.told->node;
  }
  return {};
}

std::map<Speaker, std::uint32_t> LinkMerge::digests() const {
  std::map<Speaker, std::uint32_t> digests;
  for (const auto& [id, known] : endpoints_) {
    for (const Claim& claim : known.claims) {
      if (!claim.alive) continue;
      std::uint32_t& digest = digests[claim.speaker];
      digest = add_to_digest(digest, digest_part(id, claim.endpoint->revision, asked(claim)));
    }
  }
  return digests;
}

/// A claim has a request in two places: this is the sequence of the newer one.
std::uint64_t LinkMerge::asked(const Claim& claim) {
  return std::max(claim.request ? claim.request->sequence : 0, claim.endpoint->request.sequence);
}

void LinkMerge::begin_anew(const Speaker& speaker) {
  doubt_departures();
  disbelieved_.insert(speaker);
  for (auto& [id, known] : endpoints_) {
    known.told_untrue |= known.told != nullptr && known.told->announcer == speaker.participant;
    for (Claim& claim : known.claims) claim.untrue |= claim.speaker == speaker;
    std::ranges::stable_partition(known.claims, [](const Claim& claim) { return !claim.untrue; });
  }
}

void LinkMerge::disbelieve(const Speaker& speaker, Time now) {
  begin_anew(speaker);
  for (auto& [id, known] : endpoints_) {
    if (!known.told_untrue) continue;
    known.true_from = now;
    settle(id, known, now);
  }
}

bool LinkMerge::has_room_for(const Speaker& speaker) {
  const std::size_t share = shares_[speaker.participant];
  return claims_ < limits_.endpoints && (share < limits_.share || claims_ < limits_.crowded);
}

LinkMerge::Claim* LinkMerge::claim_of(Known& known, const Speaker& speaker) const {
  const auto claim = std::ranges::find(known.claims, speaker, &Claim::speaker);
  return claim == known.claims.end() ? nullptr : &*claim;
}

bool LinkMerge::may_be_believed(const Known& known, const Claim& claim, Time now) const {
  const milliseconds silence = silence_in(claim.endpoint->life_lease);
  if (!claim.alive || claim.refused || !speakers_.speaks(claim.speaker, silence, now)) return false;
  const bool is_behind =
      known.told != nullptr && !known.told_untrue && known.told->announcer != claim.speaker.participant &&
      known.told->node_id == claim.endpoint->node_id && claim.endpoint->revision < known.told->revision;
  return !is_behind || speakers_.has_spoken_for(claim.speaker, silence, now);
}

/// The node to which the endpoint belongs: that of the first claim that is alive.
NodeId LinkMerge::node_of(const Known& known) {
  const auto alive = std::ranges::find_if(known.claims, &Claim::alive);
  return (alive == known.claims.end() ? known.claims.front() : *alive).endpoint->node_id;
}

/// The first one of its node that speaks; while none does, the one that was believed before, as long as it
/// lives.
LinkMerge::Claim* LinkMerge::believed(Known& known, Time now) const {
  if (known.claims.empty()) return nullptr;
  const NodeId node = node_of(known);
  for (Claim& claim : known.claims) {
    if (claim.endpoint->node_id == node && may_be_believed(known, claim, now)) return &claim;
  }
  Claim* first = nullptr;
  for (Claim& claim : known.claims) {
    if (!claim.alive || claim.endpoint->node_id != node) continue;
    if (known.told != nullptr && claim.endpoint->announcer == known.told->announcer) return &claim;
    if (first == nullptr && !claim.refused) first = &claim;
  }
  return first;
}

void LinkMerge::endpoint_came(const Speaker& speaker, Endpoint endpoint, Time now) {
  speakers_.heard(speaker, silence_in(endpoint.life_lease), now);
  const EndpointId id = endpoint.id;
  endpoint.announcer = speaker.participant;
  endpoint.request.announcer = speaker.participant;
  const auto sample = std::make_shared<const Endpoint>(std::move(endpoint));
  if (own_.contains(id)) {
    news_.emplace_back(EndpointSeen{sample, {}});
    return;
  }
  if (const auto departed = departed_.find(id); departed != departed_.end()) {
    if (sample->revision <= departed->second.revision) return;  // a slower link delivers it late
    departed_.erase(departed);
  }
  const auto known = endpoints_.find(id);
  const bool is_new = known == endpoints_.end() || claim_of(known->second, speaker) == nullptr;
  if (is_new && !has_room_for(speaker)) {
    return refuse("more endpoints than there is room for: one " + name_of(*sample) + " is not taken");
  }
  Known& entry = known == endpoints_.end() ? endpoints_[id] : known->second;
  if (!entry.claims.empty() && node_of(entry) != sample->node_id) {
    refuse("another node announces the endpoint " + name_of(*entry.claims.front().endpoint) +
           ": that is not taken");
    const Claim* const before = claim_of(entry, speaker);
    if (before != nullptr && before->endpoint->node_id != sample->node_id) return;
  }
  hear_claim(entry, speaker, sample, now);
  settle(id, entry, now);
}

void LinkMerge::hear_claim(Known& known, const Speaker& speaker, std::shared_ptr<const Endpoint> endpoint,
                           Time now) {
  Claim* claim = claim_of(known, speaker);
  if (claim == nullptr) {
    ++claims_;
    ++shares_[speaker.participant];
    const auto behind = std::ranges::find_if(known.claims, &Claim::untrue);
    claim = &*known.claims.insert(
        behind,
        Claim{.speaker = speaker, .endpoint = std::move(endpoint), .untrue = disbelieved_.contains(speaker)});
    adopt_early_request(*claim);
  } else if (endpoint->revision >= claim->endpoint->revision) {
    claim->endpoint = std::move(endpoint);
  }
  claim->alive = true;
  compare_claims(known, now);
}

void LinkMerge::adopt_early_request(Claim& claim) {
  std::erase_if(early_requests_, [&](EarlyRequest& early) {
    if (early.request.reader != claim.endpoint->id || early.speaker != claim.speaker) return false;
    claim.request = std::move(early.request);
    return true;
  });
}

/// A claim that says the same as the believed one, or is behind it, is another way to the same node. Who says
/// something else may be ahead for a moment, since links overtake each other.
void LinkMerge::compare_claims(Known& known, Time now) {
  const Claim* const leader = believed(known, now);
  if (leader == nullptr) return;
  for (Claim& claim : known.claims) {
    if (claim.endpoint->node_id != leader->endpoint->node_id) continue;  // it was refused when it came
    const bool agrees = &claim == leader || claim.endpoint->revision < leader->endpoint->revision ||
                        (claim.endpoint->revision == leader->endpoint->revision &&
                         say_the_same(*claim.endpoint, *leader->endpoint));
    if (agrees) {
      claim.contested_since.reset();
      claim.refused = false;
    } else if (!claim.contested_since) {
      claim.contested_since = now;
    }
  }
}

void LinkMerge::refuse_contested(Known& known, Time now) {
  const milliseconds silence = silence_in(lease_of(known));
  compare_claims(known, now);
  for (Claim& claim : known.claims) {
    if (!claim.contested_since || claim.refused || claim.untrue || now - *claim.contested_since < 2 * silence)
      continue;
    claim.refused = true;
    refuse("another participant announces the endpoint " + name_of(*known.claims.front().endpoint) +
           " otherwise than the first one, which still speaks: that is not taken");
  }
}

/// Whether its participant says that the node lives to which the claim says that the endpoint belongs. Who
/// only alters what others announce has no such node.
bool LinkMerge::is_vouched_for(const Claim& claim) const {
  const auto node = nodes_.find(claim.endpoint->node_id);
  if (node == nodes_.end()) return false;
  const auto speaker = std::ranges::find_if(node->second.claims, [&](const NodeClaim& of_node) {
    return of_node.alive && of_node.speaker.link == claim.speaker.link;
  });
  return speaker != node->second.claims.end() && speaker->speaker == claim.speaker;
}

/// Who came first may have been quicker than the endpoint's own node. A node says all the time that it lives,
/// so a claim whose speaker does not say that gives way to one whose speaker does.
void LinkMerge::prefer_vouched(Known& known, Time now) {
  const milliseconds silence = silence_in(lease_default);
  const Claim* const leader = believed(known, now);
  const auto other = std::ranges::find_if(known.claims, [&](const Claim& claim) {
    return claim.alive && !claim.untrue && is_vouched_for(claim) &&
           speakers_.speaks(claim.speaker, silence, now);
  });
  if (leader == nullptr || is_vouched_for(*leader) || other == known.claims.end())
    return known.doubted_since.reset();
  if (!known.doubted_since) known.doubted_since = now;
  if (now - *known.doubted_since < silence) return;
  known.doubted_since.reset();
  other->refused = false;
  other->contested_since.reset();
  std::rotate(known.claims.begin(), other, other + 1);
  known.told_request = 0;
  settle(known.claims.front().endpoint->id, known, now);
}

void LinkMerge::endpoint_withdrawn(const Speaker& speaker, EndpointId id, Time now) {
  if (own_.contains(id)) {
    news_.emplace_back(EndpointDeparted{id});
    return;
  }
  const auto known = endpoints_.find(id);
  if (known == endpoints_.end()) return;
  Claim* const claim = claim_of(known->second, speaker);
  if (claim == nullptr) {
    return refuse("a participant withdraws an endpoint that it has not announced: that is not taken");
  }
  const Claim* const leader = believed(known->second, now);
  if (leader == nullptr || leader == claim || claim == &known->second.claims.front()) return depart(id, now);
  --claims_;
  --shares_[speaker.participant];
  known->second.claims.erase(known->second.claims.begin() + (claim - known->second.claims.data()));
  settle(id, known->second, now);
}

void LinkMerge::depart(EndpointId id, Time now) {
  const auto known = endpoints_.find(id);
  const std::shared_ptr<const Endpoint> told = known->second.told;
  for (const Claim& claim : known->second.claims) {
    --claims_;
    --shares_[claim.speaker.participant];
  }
  endpoints_.erase(known);
  departed_[id] = {told == nullptr ? 0 : told->revision, now};
  news_.emplace_back(EndpointDeparted{id});
}

void LinkMerge::end_claim(Claim& claim, Time now) {
  if (!claim.alive) return;
  claim.alive = false;
  claim.ended = now;
}

void LinkMerge::endpoint_unheard(LinkId link, EndpointId id, Time now) {
  const auto known = endpoints_.find(id);
  if (known == endpoints_.end()) return;
  for (Claim& claim : known->second.claims) {
    if (claim.speaker.link == link) end_claim(claim, now);
  }
  settle(id, known->second, now);
}

void LinkMerge::request_came(const Speaker& speaker, Request request, Time now) {
  request.announcer = speaker.participant;
  if (own_.contains(request.reader)) {
    news_.emplace_back(std::move(request));
    return;
  }
  const auto known = endpoints_.find(request.reader);
  Claim* const claim = known == endpoints_.end() ? nullptr : claim_of(known->second, speaker);
  if (claim == nullptr) {  // before its announcement, maybe
    std::erase_if(early_requests_, [&](const EarlyRequest& e) {
      return e.request.reader == request.reader && e.speaker == speaker;
    });
    const auto of_reader = std::ranges::count(early_requests_, request.reader,
                                              [](const EarlyRequest& e) { return e.request.reader; });
    if (static_cast<std::size_t>(of_reader) >= early_requests_of_a_reader) return;
    if (early_requests_.size() >= limits_.early_requests) early_requests_.erase(early_requests_.begin());
    early_requests_.push_back({speaker, std::move(request), now});
    return;
  }
  speakers_.heard(speaker, silence_in(claim->endpoint->life_lease), now);
  if (claim->request && request.sequence <= claim->request->sequence) return;
  claim->request = std::move(request);
  settle(known->first, known->second, now);
  const Claim* const leader = believed(known->second, now);
  const bool was_believed = leader == nullptr && known->second.told != nullptr &&
                            known->second.told->announcer == speaker.participant;
  if ((leader == claim || was_believed) && claim->request->sequence > known->second.told_request) {
    known->second.told_request = claim->request->sequence;
    news_.emplace_back(*claim->request);
  }
}

/// On each link the first one that speaks for a node, or who comes after it once that is silent.
void LinkMerge::assertion_came(const Speaker& speaker, Assertion assertion, Time now) {
  const NodeId id = assertion.node;
  assertion.announcer = speaker.participant;
  const milliseconds silence = silence_in(lease_of(id));
  speakers_.heard(speaker, silence, now);
  if (!nodes_.contains(id) && nodes_.size() >= limits_.endpoints) return;
  KnownNode& node = nodes_[id];
  if (std::ranges::find(node.claims, speaker, &NodeClaim::speaker) == node.claims.end())
    node.claims.push_back({speaker});
  for (NodeClaim& claim : node.claims) {
    if (claim.speaker.link != speaker.link) continue;
    if (claim.speaker != speaker && claim.alive && speakers_.speaks(claim.speaker, silence, now)) return;
    if (claim.speaker != speaker) continue;
    claim.alive = true;
    break;
  }
  node.lost = false;
  node.lost_at.reset();
  news_.emplace_back(std::move(assertion));
}

void LinkMerge::node_unheard(LinkId link, NodeId id, Time now) {
  const auto node = nodes_.find(id);
  if (node == nodes_.end()) return;
  for (NodeClaim& claim : node->second.claims) {
    if (claim.speaker.link == link) claim.alive = false;
  }
  settle_node(id, node->second, now);
}

void LinkMerge::participant_left(const Speaker& speaker, Time now) {
  for (auto& [id, known] : endpoints_) {
    Claim* const claim = claim_of(known, speaker);
    if (claim == nullptr) continue;
    end_claim(*claim, now);
    settle(id, known, now);
  }
  for (auto& [id, node] : nodes_) {
    for (NodeClaim& claim : node.claims) claim.alive &= claim.speaker != speaker;
    settle_node(id, node, now);
  }
}

void LinkMerge::drop_claims(Known& known, LinkId link) {
  std::erase_if(known.claims, [&](const Claim& claim) {
    if (claim.speaker.link != link) return false;
    --claims_;
    --shares_[claim.speaker.participant];
    return true;
  });
}

void LinkMerge::link_dropped(LinkId link, Time now) {
  for (auto& [id, known] : endpoints_) {
    for (Claim& claim : known.claims) {
      if (claim.speaker.link == link) end_claim(claim, now);
    }
    settle(id, known, now);  // as long as it is known when they were heard
    drop_claims(known, link);
  }
  for (auto& [id, node] : nodes_) {
    for (NodeClaim& claim : node.claims) claim.alive &= claim.speaker.link != link;
    settle_node(id, node, now);
    std::erase_if(node.claims, [&](const NodeClaim& claim) { return claim.speaker.link == link; });
  }
  std::erase_if(early_requests_, [&](const EarlyRequest& early) { return early.speaker.link == link; });
  speakers_.forget_link(link);
  std::erase_if(disbelieved_, [&](const Speaker& speaker) { return speaker.link == link; });
}

void LinkMerge::replaced_link_dropped(LinkId link, Time now) {
  for (auto& [id, known] : endpoints_) {
    const bool was_told_by_it =
        known.told != nullptr && std::ranges::any_of(known.claims, [&](const Claim& claim) {
          return claim.speaker.link == link && claim.speaker.participant == known.told->announcer;
        });
    if (!was_told_by_it) continue;
    known.told_untrue = true;
    known.true_from = now;
    const bool is_heard_elsewhere =
        std::ranges::any_of(known.claims, [&](const Claim& claim) { return claim.speaker.link != link; });
    if (is_heard_elsewhere) drop_claims(known, link);
  }
  link_dropped(link, now);
}

/// An endpoint that nobody keeps alive is lost at once if its node has been silent already. Else a link was
/// dropped or made anew, here or there: then it has its lease to return by another one.
void LinkMerge::settle(EndpointId id, Known& known, Time now) {
  if (const Claim* const claim = believed(known, now)) {
    known.lost_at.reset();
    if (is_open_what_is_true(known, *claim, now)) return;
    const bool is_told = known.told != nullptr && !known.lost && !known.told_untrue &&
                         known.told->announcer == claim->endpoint->announcer &&
                         known.told->revision == claim->endpoint->revision;
    std::vector<LinkId> silent = silent_links(known, *claim, now);
    if (is_told && silent == known.told_silent) return;
    known.told_silent = std::move(silent);
    tell(known, *claim);
    return;
  }
  if (known.lost || known.told == nullptr) return;
  if (!known.lost_at) {
    Time heard{};
    for (const Claim& claim : known.claims) heard = std::max(heard, speakers_.last_heard(claim.speaker));
    const bool was_silent = now - heard > silence_in(lease_of(known));
    known.lost_at = was_silent ? now : heard + lease_of(known);
  }
  if (now < *known.lost_at) return;
  known.lost = true;
  news_.emplace_back(EndpointLost{id});
}

/// None while the believed one is silent itself: then all of the node is.
std::vector<LinkId> LinkMerge::silent_links(const Known& known, const Claim& believed, Time now) const {
  const milliseconds silence = silence_in(lease_of(known));
  const NodeId node = believed.endpoint->node_id;
  const auto speaks = [&](const Claim& claim) {
    return claim.alive && !claim.refused && claim.endpoint->node_id == node &&
           speakers_.speaks(claim.speaker, silence, now);
  };
  std::vector<LinkId> silent;
  if (!speaks(believed)) return silent;
  for (const Claim& claim : known.claims) {
    if (claim.refused || claim.endpoint->node_id != node) continue;
    const LinkId link = claim.speaker.link;
    const bool is_heard = std::ranges::any_of(
        known.claims, [&](const Claim& other) { return other.speaker.link == link && speaks(other); });
    if (!is_heard && std::ranges::find(silent, link) == silent.end()) silent.push_back(link);
  }
  std::ranges::sort(silent);
  return silent;
}

/// Returns true while it is not known yet what is true. A link that is made anew tells of requests after
/// endpoints.
bool LinkMerge::is_open_what_is_true(Known& known, const Claim& claim, Time now) {
  constexpr milliseconds requests_come_within{500};
  if (!known.told_untrue) return false;
  if (claim.untrue) return true;
  if (!known.true_from) known.true_from = now + requests_come_within;
  const bool request_may_come = known.told != nullptr && say_the_same(*known.told, *claim.endpoint) &&
                                known.told_request > asked(claim);
  return request_may_come && now < *known.true_from;
}

/// A lower number than the one that was told would be taken for old.
void LinkMerge::take_back_if_untrue(Known& known, const Claim& claim) {
  known.true_from.reset();
  if (!std::exchange(known.told_untrue, false) || known.told == nullptr) return;
  if (say_the_same(*known.told, *claim.endpoint) && known.told_request <= asked(claim)) return;
  known.told.reset();
  known.told_request = 0;
  news_.emplace_back(EndpointDeparted{claim.endpoint->id});
}

void LinkMerge::tell(Known& known, const Claim& claim) {
  take_back_if_untrue(known, claim);
  const bool is_same_speaker = known.told != nullptr && known.told->announcer == claim.endpoint->announcer;
  const bool is_same_node = known.told != nullptr && known.told->node_id == claim.endpoint->node_id;
  if (!is_same_node) known.told_request = 0;  // what another one asked for is not the reader's request
  known.told = claim.endpoint;
  known.lost = false;
  news_.emplace_back(EndpointSeen{claim.endpoint, known.told_silent});
  const bool is_told = is_same_speaker && claim.request && claim.request->sequence <= known.told_request;
  if (!claim.request || is_told || claim.request->sequence <= claim.endpoint->request.sequence) return;
  known.told_request = claim.request->sequence;
  news_.emplace_back(*claim.request);
}

void LinkMerge::settle_node(NodeId id, KnownNode& node, Time now) {
  if (node.lost || std::ranges::any_of(node.claims, &NodeClaim::alive)) return;
  if (!node.lost_at) {
    Time heard{};
    for (const NodeClaim& claim : node.claims) heard = std::max(heard, speakers_.last_heard(claim.speaker));
    const bool was_silent = now - heard > silence_in(lease_of(id));
    node.lost_at = was_silent ? now : heard + lease_of(id);
  }
  if (now < *node.lost_at) return;
  node.lost = true;
  news_.emplace_back(NodeLost{id});
}

/// Cyclone tells of the end of a lease, unless somebody else has disposed of the signs of life. There is time
/// for a link that does not hear them to be made anew (hearing_watch.h).
void LinkMerge::end_silent_claims(NodeId id, KnownNode& node, Time now) const {
  constexpr std::chrono::seconds slack{4};
  for (NodeClaim& claim : node.claims) {
    const auto silent_for = now - speakers_.last_heard(claim.speaker);
    if (claim.alive && silent_for > lease_default + slack && silent_for > lease_of(id) + slack)
      claim.alive = false;
  }
}

void LinkMerge::tick(Time now) {
  for (auto& [id, known] : endpoints_) {
    if (known.claims.size() > 1) {
      prefer_vouched(known, now);
      refuse_contested(known, now);
    }
    if (known.claims.size() != 1 || !known.claims.front().alive || known.told_untrue) settle(id, known, now);
  }
  for (auto& [id, node] : nodes_) {
    end_silent_claims(id, node, now);
    settle_node(id, node, now);
  }
  std::erase_if(early_requests_, [&](const EarlyRequest& early) {
    const auto known = endpoints_.find(early.request.reader);
    if (known == endpoints_.end()) return now - early.at > limits_.forget_after;
    if (now - early.at < silence_in(lease_of(known->second))) return false;
    refuse("a participant makes requests of the subscriber " + name_of(*known->second.told) +
           ", which it has not announced: they are not taken");
    return true;
  });
  forget_old(now);
}

void LinkMerge::forget_old(Time now) {
  const Time before = now - limits_.forget_after;
  for (auto& [id, known] : endpoints_) {
    std::erase_if(known.claims, [&](const Claim& claim) {
      if (claim.alive || claim.ended > before) return false;
      --claims_;
      --shares_[claim.speaker.participant];
      return true;
    });
  }
  std::erase_if(endpoints_, [&](const auto& entry) {
    const Known& known = entry.second;
    return known.claims.empty() && (known.told == nullptr || (known.lost && *known.lost_at <= before));
  });
  std::erase_if(departed_, [&](const auto& entry) { return entry.second.at <= before; });
  std::erase_if(shares_, [](const auto& entry) { return entry.second == 0; });
  std::erase_if(nodes_,
                [&](const auto& entry) { return entry.second.lost && *entry.second.lost_at <= before; });
  speakers_.forget_before(before - limits_.forget_after);
}

}  // namespace sft::core
