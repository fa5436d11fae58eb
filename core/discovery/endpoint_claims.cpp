#include "core/discovery/endpoint_claims.h"

#include <algorithm>
#include <utility>

#include "core/discovery/leases.h"

namespace sft::core {

using std::chrono::milliseconds;

EndpointClaims::~EndpointClaims() {
  drop([](const Claim&) { return true; });
}

template <class Which>
void EndpointClaims::drop(Which which) {
  std::erase_if(claims_, [&](const Claim& claim) {
    if (!which(claim)) return false;
    context_.counts.remove(claim.speaker.participant, weight_of(*claim.endpoint));
    return true;
  });
}

const Endpoint& EndpointClaims::announced_by(const Speaker& speaker) const {
  return *std::ranges::find(claims_, speaker, &Claim::speaker)->endpoint;
}

Claim* EndpointClaims::of(const Speaker& speaker) {
  const auto claim = std::ranges::find(claims_, speaker, &Claim::speaker);
  return claim == claims_.end() ? nullptr : &*claim;
}

bool EndpointClaims::is_announced_by(const Speaker& speaker) const {
  return std::ranges::find(claims_, speaker, &Claim::speaker) != claims_.end();
}

/// The node to which the endpoint belongs: that of the first claim that is alive.
NodeId EndpointClaims::node() const {
  const auto alive = std::ranges::find_if(claims_, &Claim::alive);
  return (alive == claims_.end() ? claims_.front() : *alive).endpoint->node_id;
}

bool EndpointClaims::may_be_believed(const Claim& claim, Time now) const {
  const milliseconds silence = silence_in(claim.endpoint->life_lease);
  if (!claim.alive || claim.refused || !context_.speakers.speaks(claim.speaker, silence, now)) return false;
  return !told_.is_ahead_of(claim) || context_.speakers.has_spoken_for(claim.speaker, silence, now);
}

/// The first claim of the endpoint's node whose speaker speaks. While none speaks, the claim that was
/// believed before, as long as it lives.
Claim* EndpointClaims::believed(Time now) {
  if (claims_.empty()) return nullptr;
  const NodeId of_node = node();
  for (Claim& claim : claims_) {
    if (claim.endpoint->node_id == of_node && may_be_believed(claim, now)) return &claim;
  }
  Claim* first = nullptr;
  for (Claim& claim : claims_) {
    if (!claim.alive || claim.endpoint->node_id != of_node) continue;
    if (told_.is_by(claim.endpoint->announcer)) return &claim;
    if (first == nullptr && !claim.refused) first = &claim;
  }
  return first;
}

bool EndpointClaims::accepts(const Speaker& speaker, const Endpoint& endpoint) const {
  if (claims_.empty() || node() == endpoint.node_id) return true;
  context_.refuse("another node announces the endpoint " + name_of(*claims_.front().endpoint) +
                  ": that is not taken");
  const auto before = std::ranges::find(claims_, speaker, &Claim::speaker);
  return before == claims_.end() || before->endpoint->node_id == endpoint.node_id;
}

void EndpointClaims::announced(const Speaker& speaker, std::shared_ptr<const Endpoint> endpoint, Time now) {
  Claim& claim = *of(speaker);
  if (endpoint->revision >= claim.endpoint->revision) {
    context_.counts.remove(speaker.participant, weight_of(*claim.endpoint));
    claim.endpoint = std::move(endpoint);
    context_.counts.add(speaker.participant, weight_of(*claim.endpoint));
  }
  claim.alive = true;
  compare(now);
  settle(now);
}

void EndpointClaims::add(const Speaker& speaker, std::shared_ptr<const Endpoint> endpoint,
                         std::optional<Request> early_request, bool is_disbelieved, Time now) {
  context_.counts.add(speaker.participant, weight_of(*endpoint));
  claims_.insert(std::ranges::find_if(claims_, &Claim::untrue), Claim{.speaker = speaker,
                                                                      .endpoint = std::move(endpoint),
                                                                      .request = std::move(early_request),
                                                                      .untrue = is_disbelieved});
  compare(now);
  settle(now);
}

/// A claim that says the same as the believed one, or is behind it, is another way to the same node. A claim
/// that says something else may be ahead for a moment, since links overtake each other.
void EndpointClaims::compare(Time now) {
  const Claim* const leader = believed(now);
  if (leader == nullptr) return;
  for (Claim& claim : claims_) {
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
  compared_with_ = leader->speaker;
}

void EndpointClaims::refuse_contested(Time now) {
  const milliseconds silence = silence_in(told_.lease());
  const Claim* const leader = believed(now);
  if (leader != nullptr && compared_with_ != leader->speaker) compare(now);
  for (Claim& claim : claims_) {
    if (!claim.contested_since || claim.refused || claim.untrue || now - *claim.contested_since < 2 * silence)
      continue;
    claim.refused = true;
    context_.refuse("another participant announces the endpoint " + name_of(*claims_.front().endpoint) +
                    " otherwise than the first one, which still speaks: that is not taken");
  }
}

/// The first speaker may have been quicker than the endpoint's own node. A node says all the time that it
/// lives: a claim whose speaker does not say that gives way to one whose speaker does.
/// A participant that only alters what others announce has no node that it could speak for.
void EndpointClaims::prefer_vouched(Time now) {
  const auto is_vouched_for = [this](const Claim& claim) {
    return context_.nodes.is_vouched_for(claim.endpoint->node_id, claim.speaker);
  };
  const milliseconds silence = silence_in(lease_default);
  const Claim* const leader = believed(now);
  const auto other = std::ranges::find_if(claims_, [&](const Claim& claim) {
    return claim.alive && !claim.untrue && is_vouched_for(claim) &&
           context_.speakers.speaks(claim.speaker, silence, now);
  });
  if (leader == nullptr || is_vouched_for(*leader) || other == claims_.end()) return doubted_since_.reset();
  if (!doubted_since_) doubted_since_ = now;
  if (now - *doubted_since_ < silence) return;
  doubted_since_.reset();
  other->refused = false;
  other->contested_since.reset();
  std::rotate(claims_.begin(), other, other + 1);
  told_.forget_request();
  settle(now);
}

bool EndpointClaims::withdrawn(const Speaker& speaker, Time now) {
  const Claim* const claim = of(speaker);
  const Claim* const leader = believed(now);
  if (leader == nullptr || leader == claim || claim == &claims_.front()) return true;
  drop([&](const Claim& one) { return one.speaker == speaker; });
  settle(now);
  return false;
}

void EndpointClaims::requested(const Speaker& speaker, Request request, Time now) {
  Claim* const claim = of(speaker);
  if (claim->request && request.sequence <= claim->request->sequence) return;
  claim->request = std::move(request);
  settle(now);
  const Claim* const leader = believed(now);
  const bool was_believed = leader == nullptr && told_.is_by(speaker.participant);
  if (leader == claim || was_believed) told_.request(*claim->request);
}

void EndpointClaims::unheard(LinkId link, Time now) {
  for (Claim& claim : claims_) {
    if (claim.speaker.link == link) claim.end(now);
  }
  settle(now);
}

void EndpointClaims::participant_departed(const Speaker& speaker, Time now) {
  Claim* const claim = of(speaker);
  if (claim == nullptr) return;
  claim->end(now);
  settle(now);
}

/// The claims are settled before they are dropped: as long as it is known when their speakers were heard.
void EndpointClaims::link_dropped(LinkId link, Time now) {
  unheard(link, now);
  drop([&](const Claim& claim) { return claim.speaker.link == link; });
}

void EndpointClaims::link_is_replaced(LinkId link, Time now) {
  const bool was_told_by_it = std::ranges::any_of(claims_, [&](const Claim& claim) {
    return claim.speaker.link == link && told_.is_by(claim.speaker.participant);
  });
  if (!was_told_by_it) return;
  told_.doubt();
  told_.doubt_until(now);
  const bool is_heard_elsewhere =
      std::ranges::any_of(claims_, [&](const Claim& claim) { return claim.speaker.link != link; });
  if (is_heard_elsewhere) drop([&](const Claim& claim) { return claim.speaker.link == link; });
}

void EndpointClaims::begin_anew(const Speaker& speaker) {
  if (told_.is_by(speaker.participant)) told_.doubt();
  for (Claim& claim : claims_) claim.untrue |= claim.speaker == speaker;
  std::ranges::stable_partition(claims_, [](const Claim& claim) { return !claim.untrue; });
}

void EndpointClaims::trust_others(Time now) {
  if (!told_.is_in_doubt()) return;
  told_.doubt_until(now);
  settle(now);
}

void EndpointClaims::tick(Time now) {
  if (claims_.size() > 1) {
    prefer_vouched(now);
    refuse_contested(now);
  }
  if (claims_.size() != 1 || !claims_.front().alive || told_.is_in_doubt()) settle(now);
}

/// Tells what is believed, if that has changed.
void EndpointClaims::settle(Time now) {
  if (const Claim* const claim = believed(now)) return told_.believe(*claim, silent_links(*claim, now), now);
  Time heard{};
  for (const Claim& claim : claims_)
    heard = std::max(heard, context_.speakers.last_heard(claim.speaker, now));
  told_.lose(heard, now);
}

bool EndpointClaims::speaks(const Claim& claim, Time now) const {
  return claim.alive && !claim.refused &&
         context_.speakers.speaks(claim.speaker, silence_in(told_.lease()), now);
}

/// No links while the believed speaker is silent itself: then all of the node is.
std::vector<LinkId> EndpointClaims::silent_links(const Claim& believed, Time now) const {
  std::vector<LinkId> silent;
  if (!speaks(believed, now)) return silent;
  const NodeId of_node = believed.endpoint->node_id;
  for (const Claim& claim : claims_) {
    if (claim.refused || claim.endpoint->node_id != of_node) continue;
    const LinkId link = claim.speaker.link;
    const bool is_heard = std::ranges::any_of(claims_, [&](const Claim& other) {
      return other.speaker.link == link && other.endpoint->node_id == of_node && speaks(other, now);
    });
    if (!is_heard && std::ranges::find(silent, link) == silent.end()) silent.push_back(link);
  }
  std::ranges::sort(silent);
  return silent;
}

bool EndpointClaims::forget_before(Time before) {
  drop([&](const Claim& claim) { return !claim.alive && claim.ended <= before; });
  return claims_.empty() && (told_.endpoint() == nullptr || told_.is_lost_before(before));
}

}  // namespace sft::core
