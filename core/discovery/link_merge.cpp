#include "core/discovery/link_merge.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "core/control/control_digest.h"
#include "core/discovery/leases.h"

namespace sft::core {

using std::chrono::milliseconds;

namespace {
constexpr milliseconds tick_pause_min{100}, tick_pause_max{500};
constexpr std::size_t endpoints_per_millisecond = 4;  // 4000 endpoints are looked at in a second
constexpr std::chrono::seconds forget_every{1};
}  // namespace

milliseconds LinkMerge::pause_between_ticks() const {
  return std::clamp(milliseconds(endpoints_.size() / endpoints_per_millisecond), tick_pause_min,
                    tick_pause_max);
}

milliseconds LinkMerge::lease_of(NodeId node) const {
  const Endpoint* const endpoint = endpoints_.some_told_of(node);
  return endpoint == nullptr ? lease_default : std::min(endpoint->life_lease, lease_max);
}

LinkMerge::Unrest LinkMerge::unrest() const {
  const NodeClaims::Lives lives = nodes_.lives();
  Unrest unrest{.has_rivals = lives.has_rivals,
                .is_any = lives.awaits_loss || !early_requests_.empty(),
                .living = lives.living};
  endpoints_.each([&](EndpointId, const EndpointClaims& claims) {
    int speakers = 0;
    claims.each_alive([&](const Claim& claim) {
      ++speakers;
      unrest.is_any |= claim.contested_since.has_value() || claim.refused || claim.untrue;
    });
    const ToldEndpoint& told = claims.told();
    unrest.has_rivals |= speakers > 1;
    unrest.is_any |= told.is_in_doubt() || told.lease() < lease_default || (speakers == 0 && !told.is_lost());
  });
  unrest.is_any |= unrest.has_rivals;
  return unrest;
}

std::map<Speaker, std::uint32_t> LinkMerge::digests() const {
  std::map<Speaker, std::uint32_t> digests;
  endpoints_.each([&](EndpointId id, const EndpointClaims& claims) {
    claims.each_alive([&](const Claim& claim) {
      std::uint32_t& digest = digests[claim.speaker];
      digest = add_to_digest(digest, digest_part(id, claim.endpoint->revision, claim.asked()));
    });
  });
  return digests;
}

void LinkMerge::begin_anew(const Speaker& speaker) {
  doubt_departures();
  disbelieved_.insert(speaker);
  endpoints_.each([&](EndpointClaims& claims) { claims.begin_anew(speaker); });
}

void LinkMerge::disbelieve(const Speaker& speaker, Time now) {
  begin_anew(speaker);
  endpoints_.each([&](EndpointClaims& claims) { claims.trust_others(now); });
}

void LinkMerge::endpoint_came(const Speaker& speaker, Endpoint endpoint, Time now) {
  speakers_.heard(speaker, silence_in(endpoint.life_lease), now);
  const EndpointId id = endpoint.id;
  endpoint.announcer = speaker.participant;
  endpoint.request.announcer = speaker.participant;
  auto sample = std::make_shared<const Endpoint>(std::move(endpoint));
  if (own_.contains(id)) {
    news_.emplace_back(EndpointSeen{std::move(sample), {}});
    return;
  }
  if (const auto departed = departed_.find(id); departed != departed_.end()) {
    if (sample->revision <= departed->second.revision) return;  // a slower link delivers it late
    departed_.erase(departed);
  }
  EndpointClaims* claims = endpoints_.find(id);
  const bool is_new = claims == nullptr || !claims->is_announced_by(speaker);
  const std::size_t has = weight_of(*sample);
  const std::size_t had = is_new ? 0 : weight_of(claims->announced_by(speaker));
  if (has > had && !counts_.has_room_for(speaker.participant, has - had)) {
    return context_.refuse("the table of endpoints has no more room for this participant: its endpoint " +
                           name_of(*sample) + " is refused");
  }
  if (claims == nullptr) claims = &endpoints_[id];
  if (!claims->accepts(speaker, *sample)) return;
  endpoints_.belongs_to(id, sample->node_id);
  if (!is_new) return claims->announced(speaker, std::move(sample), now);
  claims->add(speaker, std::move(sample), early_requests_.take(speaker, id), disbelieved_.contains(speaker),
              now);
}

void LinkMerge::endpoint_withdrawn(const Speaker& speaker, EndpointId id, Time now) {
  if (own_.contains(id)) {
    news_.emplace_back(EndpointDeparted{id});
    return;
  }
  EndpointClaims* const claims = endpoints_.find(id);
  if (claims == nullptr) return;
  if (!claims->is_announced_by(speaker)) {
    return context_.refuse(
        "a participant withdraws an endpoint that it has not announced: the withdrawal is refused");
  }
  if (!claims->withdrawn(speaker, now)) return;
  const Endpoint* const told = claims->told().endpoint();
  departed_[id] = {told == nullptr ? 0 : told->revision, now};
  endpoints_.erase(id);
  news_.emplace_back(EndpointDeparted{id});
}

void LinkMerge::endpoint_unheard(LinkId link, EndpointId id, Time now) {
  if (EndpointClaims* const claims = endpoints_.find(id)) claims->unheard(link, now);
}

void LinkMerge::request_came(const Speaker& speaker, Request request, Time now) {
  request.announcer = speaker.participant;
  if (own_.contains(request.reader)) {
    news_.emplace_back(std::move(request));
    return;
  }
  EndpointClaims* const claims = endpoints_.find(request.reader);
  if (claims == nullptr || !claims->is_announced_by(speaker))  // the announcement may still come
    return early_requests_.keep(speaker, std::move(request), now);
  speakers_.heard(speaker, silence_in(claims->announced_by(speaker).life_lease), now);
  claims->requested(speaker, std::move(request), now);
}

void LinkMerge::assertion_came(const Speaker& speaker, Assertion assertion, Time now) {
  assertion.announcer = speaker.participant;
  const milliseconds silence = silence_in(lease_of(assertion.node));
  speakers_.heard(speaker, silence, now);
  if (nodes_.asserted(assertion.node, speaker, silence, now)) news_.emplace_back(std::move(assertion));
}

void LinkMerge::pulse_came(const Speaker& speaker, std::optional<NodeId> living, Time now) {
  speakers_.pulse_came(speaker, now);
  if (living) assertion_came(speaker, {.node = *living, .writers = {}}, now);
}

void LinkMerge::pulses_came_until(const Speaker& speaker, NodeId node, Time last) {
  speakers_.pulses_came_until(speaker, last);
  nodes_.asserted(node, speaker, silence_in(lease_of(node)), last);
}

void LinkMerge::node_unheard(LinkId link, NodeId id, Time now) {
  const auto lease = [this](NodeId node) { return lease_of(node); };
  if (nodes_.unheard(id, link, lease, now)) news_.emplace_back(NodeLost{id});
}

void LinkMerge::tell_lost_nodes(Time now) {
  for (const NodeId id : nodes_.take_lost([this](NodeId node) { return lease_of(node); }, now))
    news_.emplace_back(NodeLost{id});
}

void LinkMerge::participant_departed(const Speaker& speaker, Time now) {
  endpoints_.each([&](EndpointClaims& claims) { claims.participant_departed(speaker, now); });
  nodes_.participant_departed(speaker);
  tell_lost_nodes(now);
}

void LinkMerge::link_dropped(LinkId link, Time now) {
  endpoints_.each([&](EndpointClaims& claims) { claims.link_dropped(link, now); });
  nodes_.link_dropped(link);
  tell_lost_nodes(now);
  nodes_.forget_link(link);
  early_requests_.forget_link(link);
  speakers_.forget_link(link);
  std::erase_if(disbelieved_, [&](const Speaker& speaker) { return speaker.link == link; });
}

void LinkMerge::replaced_link_dropped(LinkId link, Time now) {
  endpoints_.each([&](EndpointClaims& claims) { claims.link_is_replaced(link, now); });
  link_dropped(link, now);
}

void LinkMerge::tick(Time now) {
  endpoints_.each([&](EndpointClaims& claims) { claims.tick(now); });
  nodes_.end_silent([this](NodeId node) { return lease_of(node); }, now);
  tell_lost_nodes(now);
  refuse_old_requests(now);
  forget_old(now);
}

void LinkMerge::end_what_was_lost_of(const std::set<NodeId>& nodes_known_whole) {
  std::vector<EndpointId> departed;
  std::as_const(endpoints_).each([&](EndpointId id, const EndpointClaims& claims) {
    const ToldEndpoint& told = claims.told();
    if (told.is_lost() && nodes_known_whole.contains(told.endpoint()->node_id)) departed.push_back(id);
  });
  for (const EndpointId id : departed) {
    endpoints_.erase(id);
    news_.emplace_back(EndpointDeparted{id});
  }
}

/// A request that comes before its announcement waits for it. If another participant has announced the
/// reader, nobody has to wait long.
void LinkMerge::refuse_old_requests(Time now) {
  early_requests_.forget_if(
      [&](EndpointId reader, Time::duration age) {
        const EndpointClaims* const claims = endpoints_.find(reader);
        if (claims == nullptr) return age > limits_.forget_after;
        if (age < silence_in(claims->told().lease())) return false;
        context_.refuse("a participant makes requests of the subscriber " +
                        name_of(*claims->told().endpoint()) +
                        ", which it has not announced: they are not taken");
        return true;
      },
      now);
}

void LinkMerge::forget_old(Time now) {
  if (now < forgets_at_) return;
  forgets_at_ = now + forget_every;
  const Time before = now - limits_.forget_after;
  endpoints_.forget_before(before);
  std::erase_if(departed_, [&](const auto& entry) { return entry.second.at <= before; });
  nodes_.forget_before(before, [this](NodeId id) { return endpoints_.some_told_of(id) != nullptr; });
  speakers_.forget_before(before - limits_.forget_after);
}

}  // namespace sft::core
