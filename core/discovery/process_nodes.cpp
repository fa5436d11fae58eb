#include "core/discovery/process_nodes.h"

#include <algorithm>
#include <tuple>
#include <utility>
#include <variant>

namespace sft::core {

namespace {
std::shared_ptr<const NodeListeners> only(const std::shared_ptr<NodeListener>& member) {
  return std::make_shared<const NodeListeners>(NodeListeners{member});
}
}  // namespace

bool ProcessNodes::Hearer::is_concerned_by(const Endpoint& endpoint) const {
  const auto own = topics.find(other(endpoint.role));
  return hears_all.contains(endpoint.role) || (own != topics.end() && own->second.contains(endpoint.topic));
}

ProcessNodes::Hearer& ProcessNodes::of(const std::shared_ptr<NodeListener>& member) {
  return *std::ranges::find(hearers_, member, &Hearer::member);
}

void ProcessNodes::join(const std::shared_ptr<NodeListener>& member) {
  hearers_.push_back({.member = member, .number = ++last_number_});
}

NodeId ProcessNodes::leave(const std::shared_ptr<NodeListener>& member) {
  const NodeId node = of(member).node;
  if (of(member).asserted && !of(member).is_lost) tell_all_others(member, NodeLost{node});
  std::erase_if(hearers_, [&](const Hearer& one) { return one.member == member; });
  return node;
}

void ProcessNodes::hears_all(const std::shared_ptr<NodeListener>& member, Role role,
                             const ClaimedEndpoints& known) {
  Hearer& hearer = of(member);
  if (hearer.hears_all.contains(role)) return;
  const auto is_new = [&](const Endpoint& one) { return one.role == role && !hearer.is_concerned_by(one); };
  tell_what_is_in_force(hearer, is_new, known);
  hearer.hears_all.insert(role);
}

void ProcessNodes::announced(const std::shared_ptr<NodeListener>& member, Endpoint endpoint,
                             const ClaimedEndpoints& known) {
  Hearer& hearer = of(member);
  hearer.node = endpoint.node_id;
  endpoint.announcer = endpoint.request.announcer = hearer.number;
  const bool is_known = own_.contains(endpoint.id);
  Own& own = own_[endpoint.id];
  if (own.request && own.request->sequence <= endpoint.request.sequence) own.request.reset();
  own.by = member;
  own.endpoint = std::make_shared<const Endpoint>(std::move(endpoint));
  tell_others(own, EndpointSeen{own.endpoint});
  if (is_known) return;
  const auto& [role, topic] = std::tie(own.endpoint->role, own.endpoint->topic);
  const auto is_new = [&](const Endpoint& one) {
    return one.role == other(role) && one.topic == topic && !hearer.is_concerned_by(one);
  };
  tell_what_is_in_force(hearer, is_new, known);
  hearer.endpoints.insert(own.endpoint->id);
  ++hearer.topics[role][topic];
}

/// A member that has no endpoint of a topic any more is not told what becomes of others' endpoints of it, so
/// it must not keep them.
void ProcessNodes::withdrawn(EndpointId id, const ClaimedEndpoints& known) {
  const auto own = own_.extract(id);
  if (!own) return;
  const Endpoint& endpoint = *own.mapped().endpoint;
  tell_others(own.mapped(), EndpointDeparted{id});
  Hearer& hearer = of(own.mapped().by);
  hearer.endpoints.erase(id);
  auto& topics = hearer.topics[endpoint.role];
  const auto topic = topics.find(endpoint.topic);
  if (--topic->second > 0) return;
  topics.erase(topic);
  const Role others = other(endpoint.role);
  if (hearer.hears_all.contains(others)) return;
  const auto forget = [&, to = only(hearer.member)](const Endpoint& one) {
    if (one.role == others && one.topic == endpoint.topic) tell(to, EndpointDeparted{one.id});
  };
  for (const auto& [other_id, one] : own_) {
    if (one.by != hearer.member) forget(*one.endpoint);
  }
  known.each([&](EndpointId, const EndpointClaims& claims) {
    if (const Endpoint* const told = claims.told().endpoint()) forget(*told);
  });
}

void ProcessNodes::requested(const Request& request) {
  const auto own = own_.find(request.reader);
  if (own == own_.end()) return;
  own->second.request = request;
  own->second.request->announcer = own->second.endpoint->announcer;
  tell_others(own->second, *own->second.request);
}

/// A node whose agent did nothing for a while, and goes on, is back with all its endpoints.
void ProcessNodes::asserted(const std::shared_ptr<NodeListener>& member, Assertion assertion, Time now) {
  Hearer& hearer = of(member);
  hearer.node = assertion.node;
  hearer.asserted = now;
  assertion.announcer = hearer.number;
  const bool was_lost = std::exchange(hearer.is_lost, false);
  if (hearers_.size() == 1) return;  // nobody else is there to be told
  std::vector<const Endpoint*> endpoints;
  for (const EndpointId id : hearer.endpoints) {
    const Own& own = own_.at(id);
    if (was_lost) tell_others(own, EndpointSeen{own.endpoint});
    if (was_lost && own.request) tell_others(own, *own.request);
    endpoints.push_back(own.endpoint.get());
  }
  std::shared_ptr<const NodeListeners> to = concerned_by(assertion, endpoints, member.get());
  tell(std::move(to), std::move(assertion));
}

std::vector<EndpointId> ProcessNodes::endpoints_of(const std::shared_ptr<NodeListener>& member) const {
  const auto hearer = std::ranges::find(hearers_, member, &Hearer::member);
  return {hearer->endpoints.begin(), hearer->endpoints.end()};
}

std::vector<NodeId> ProcessNodes::living(Time since) const {
  std::vector<NodeId> nodes;
  for (const Hearer& one : hearers_) {
    if (one.asserted && *one.asserted >= since) nodes.push_back(one.node);
  }
  return nodes;
}

bool ProcessNodes::has(NodeId node) const {
  return std::ranges::find(hearers_, node, &Hearer::node) != hearers_.end();
}

const Endpoint* ProcessNodes::find(EndpointId id) const {
  const auto own = own_.find(id);
  return own == own_.end() ? nullptr : own->second.endpoint.get();
}

void ProcessNodes::tick(Time now) {
  for (Hearer& hearer : hearers_) {
    if (!hearer.asserted || hearer.is_lost || now - *hearer.asserted <= lease_) continue;
    hearer.is_lost = true;
    for (const EndpointId id : hearer.endpoints) tell_others(own_.at(id), EndpointLost{id});
    tell_all_others(hearer.member, NodeLost{hearer.node});
  }
}

void ProcessNodes::pass_on(std::vector<News> news, const ClaimedEndpoints& known) {
  for (News& one : news) {
    std::shared_ptr<const NodeListeners> to = concerned_by(one, known);
    tell(std::move(to), std::move(one));
  }
}

template <class Which>
std::shared_ptr<const NodeListeners> ProcessNodes::members_that(Which which) const {
  auto members = std::make_shared<NodeListeners>();
  for (const Hearer& one : hearers_) {
    if (which(one)) members->push_back(one.member);
  }
  return members;
}

/// A sign of life concerns those whom any endpoint of its node concerns, and those whose endpoints it asks
/// about. `by`: null if it is another process's.
std::shared_ptr<const NodeListeners> ProcessNodes::concerned_by(const Assertion& sign,
                                                                const std::vector<const Endpoint*>& endpoints,
                                                                const NodeListener* by) const {
  return members_that([&](const Hearer& one) {
    const auto concerns = [&](const Endpoint* endpoint) { return one.is_concerned_by(*endpoint); };
    const auto is_own = [&](EndpointId id) { return one.endpoints.contains(id); };
    return one.member.get() != by &&
           (std::ranges::any_of(endpoints, concerns) || std::ranges::any_of(sign.asked_about, is_own));
  });
}

/// A claim of others in the name of a member's own endpoint comes to that member, which answers it. An
/// endpoint that departs may have been known by another topic, so that everybody is told.
std::shared_ptr<const NodeListeners> ProcessNodes::concerned_by(const News& news,
                                                                const ClaimedEndpoints& known) const {
  if (const auto* const sign = std::get_if<Assertion>(&news)) {
    std::vector<const Endpoint*> endpoints;
    known.each_told_of(sign->node, [&](const Endpoint& one) {
      endpoints.push_back(&one);
      return true;
    });
    return concerned_by(*sign, endpoints, nullptr);
  }
  const std::optional<EndpointId> id = endpoint_of(news);
  if (const auto own = id ? own_.find(*id) : own_.end(); own != own_.end()) return only(own->second.by);
  const auto* const seen = std::get_if<EndpointSeen>(&news);
  const bool is_known = id && !std::holds_alternative<EndpointDeparted>(news);
  const Endpoint* const endpoint = seen != nullptr ? seen->endpoint.get()
                                   : is_known      ? known.told(*id)
                                                   : nullptr;
  return members_that(
      [&](const Hearer& one) { return endpoint == nullptr || one.is_concerned_by(*endpoint); });
}

void ProcessNodes::tell(std::shared_ptr<const NodeListeners> members, News news) {
  if (!members->empty()) news_.push_back({std::move(news), std::move(members)});
}

namespace {
/// An announcement that is repeated is no sign that its node lives.
void mark_as_silent(News& announcement) {
  EndpointSeen& seen = std::get<EndpointSeen>(announcement);
  Endpoint silent = *seen.endpoint;
  silent.life_lease = {};
  seen.endpoint = std::make_shared<const Endpoint>(std::move(silent));
}
}  // namespace

void ProcessNodes::tell_what_is_in_force(const Hearer& hearer,
                                         const std::function<bool(const Endpoint&)>& is_new,
                                         const ClaimedEndpoints& known) {
  const std::shared_ptr<const NodeListeners> to = only(hearer.member);
  for (const auto& [id, own] : own_) {
    if (own.by == hearer.member || of(own.by).is_lost || !is_new(*own.endpoint)) continue;
    tell(to, EndpointSeen{own.endpoint});
    if (own.request) tell(to, *own.request);
  }
  std::vector<News> in_force;
  known.each([&](EndpointId, const EndpointClaims& claims) {
    const Endpoint* const told = claims.told().endpoint();
    if (told == nullptr || !is_new(*told)) return;
    const std::size_t before = in_force.size();
    claims.told().repeat(in_force);
    if (in_force.size() > before && known.is_silent(told->node_id)) mark_as_silent(in_force[before]);
  });
  for (News& one : in_force) tell(to, std::move(one));
}

void ProcessNodes::tell_others(const Own& own, News news) {
  tell(members_that(
           [&](const Hearer& one) { return one.member != own.by && one.is_concerned_by(*own.endpoint); }),
       std::move(news));
}

void ProcessNodes::tell_all_others(const std::shared_ptr<NodeListener>& member, News news) {
  tell(members_that([&](const Hearer& one) { return one.member != member; }), std::move(news));
}

}  // namespace sft::core
