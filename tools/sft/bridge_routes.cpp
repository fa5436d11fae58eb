#include "tools/sft/bridge_routes.h"

#include <sft/msg_text.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <tuple>

namespace sft::tool {

namespace {

using namespace std::chrono_literals;

constexpr const char* routes_definition =
    "uint64 bridge\nsft_bridge/Route[] routes\n===\nMSG: sft_bridge/Route\nuint64 origin\nuint32 bridges\n"
    "string topic\nuint64 publisher\n";
/// Another bridge that starts at the same time receives a route within this time.
constexpr auto settling_time = 1s;
/// After this time all bridges that were there before are known.
constexpr auto discovery_time = 3s;
/// The routes of a bridge that has been discovered are awaited for this time.
constexpr auto hearing_time = 5s;
/// After an outage of the network, a bridge does not announce its old routes again. So they are kept.
constexpr auto memory_time = 1h;
constexpr std::uint32_t bridges_most = 64;   // in a chain
constexpr std::size_t routes_most = 16'384;  // of one bridge
constexpr std::size_t routes_bytes_most = 4 << 20;

}  // namespace

Result<BridgeRoutes> BridgeRoutes::open(Node& node, std::uint64_t bridge) {
  const Result<DynamicType> type = from_msg("sft_bridge/Routes", routes_definition);
  if (!type) return tl::unexpected(type.error());
  const std::string topic = std::string("/") + bridge_topic;
  Result<DynamicPublisher> publisher = node.publisher(
      topic, *type,
      {.reliability = reliable, .durability = transient_local, .max_sample_bytes = routes_bytes_most});
  if (!publisher) return tl::unexpected(publisher.error());
  Result<DynamicSubscriber> subscriber =
      node.subscriber(topic, *type, "*", {.reliability = reliable, .durability = transient_local});
  if (!subscriber) return tl::unexpected(subscriber.error());
  return BridgeRoutes(bridge, *std::move(publisher), *std::move(subscriber));
}

void BridgeRoutes::look(const DomainSnapshot& domain, Time now) {
  while (const DynamicSample sample = subscriber_.take()) {
    const Result<std::string> text = sample.to_json();
    const auto json = nlohmann::json::parse(text ? *text : "", nullptr, false);
    if (json.is_discarded() || json["routes"].size() > routes_most) continue;
    Other& other = others_[sample.info().writer];
    other = {.bridge = json["bridge"].get<std::uint64_t>(), .heard = now, .seen = other.seen};
    for (const auto& route : json["routes"]) {
      if (route["bridges"].get<std::uint32_t>() > bridges_most) continue;
      other.routes.push_back({.origin = route["origin"].get<std::uint64_t>(),
                              .bridges = route["bridges"].get<std::uint32_t>(),
                              .topic = route["topic"].get<std::string>(),
                              .publisher = route["publisher"].get<std::uint64_t>()});
    }
  }
  publishers_.clear();
  std::map<std::uint64_t, Time> unheard;
  for (const DomainSnapshot::Endpoint& publisher : domain.publishers) {
    publishers_.insert(publisher.id);
    if (publisher.is_own || publisher.topic != bridge_topic || others_.contains(publisher.id)) continue;
    const auto known = unheard_.find(publisher.id);
    unheard.emplace(publisher.id, known == unheard_.end() ? now : known->second);
  }
  unheard_ = std::move(unheard);
  for (auto& [id, other] : others_) {
    if (publishers_.contains(id)) other.seen = now;
    const bool is_awaited = other.seen == Time{} && now - other.heard < hearing_time;
    other.is_there = is_awaited || other.seen == now;
  }
  std::erase_if(others_, [&](const auto& one) {
    return now - std::max(one.second.seen, one.second.heard) > memory_time;
  });
}

std::optional<BridgeRoutes::Source> BridgeRoutes::source_of(const DomainSnapshot::Endpoint& publisher) const {
  for (const auto& [id, other] : others_) {
    if (!other.is_there) continue;
    const auto route = std::ranges::find_if(
        other.routes, [&](const Route& one) { return one.publisher == publisher.id && one.bridges > 0; });
    if (route != other.routes.end()) return Source{route->origin, route->bridges};
  }
  if (publisher.node.starts_with(bridge_node_prefix)) return std::nullopt;
  return Source{publisher.id, 0};
}

BridgeRoutes::Verdict BridgeRoutes::verdict(const Source& source, const std::string& topic, Time now) const {
  const auto is_here = [&](const Route& route) {
    return route.bridges == 0 && route.origin == source.origin;
  };
  if (publishers_.contains(source.origin) || std::ranges::any_of(announced_, is_here))
    return Verdict::belongs_there;
  const std::uint32_t bridges = source.bridges + 1;
  const bool is_carried = std::ranges::any_of(announced_, [&](const Route& own) {
    return own.origin == source.origin && own.topic == topic && own.publisher != 0;
  });
  for (const auto& [id, other] : others_) {
    if (!other.is_there) continue;
    if (std::ranges::any_of(other.routes, is_here)) return Verdict::belongs_there;
    for (const Route& route : other.routes) {
      if (route.origin != source.origin || route.topic != topic) continue;
      // The other bridge ends its route as soon as it receives a better one.
      if ((route.publisher != 0 && !is_carried) ||
          std::tie(route.bridges, other.bridge) < std::tie(bridges, bridge_))
        return Verdict::held_by_another;
    }
  }
  return is_settled(source, topic, now) ? Verdict::holds : Verdict::settles;
}

bool BridgeRoutes::is_settled(const Source& source, const std::string& topic, Time now) const {
  const auto since = since_.find({source.origin, topic});
  if (since == since_.end()) return false;
  const auto is_awaited = [&](const auto& one) { return now - one.second < hearing_time; };
  if (std::ranges::any_of(unheard_, is_awaited)) return false;
  const bool has_others =
      !unheard_.empty() || std::ranges::any_of(others_, [](const auto& one) { return one.second.is_there; });
  const bool is_alone = !has_others && now - opened_ > discovery_time;
  return is_alone || now - since->second >= settling_time;
}

void BridgeRoutes::announce(std::vector<Route> routes, Time now) {
  std::ranges::sort(routes);
  if (routes == announced_) return;
  nlohmann::json list = nlohmann::json::array();
  std::map<std::pair<std::uint64_t, std::string>, Time> since;
  for (const Route& route : routes) {
    list.push_back({{"origin", route.origin},
                    {"bridges", route.bridges},
                    {"topic", route.topic},
                    {"publisher", route.publisher}});
    if (route.bridges == 0) continue;
    const std::pair key(route.origin, route.topic);
    const auto known = since_.find(key);
    since.emplace(key, known == since_.end() ? now : known->second);
  }
  const nlohmann::json message{{"bridge", bridge_}, {"routes", std::move(list)}};
  if (!publisher_.publish_json(message.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)))
    return;
  announced_ = std::move(routes);
  since_ = std::move(since);
}

}  // namespace sft::tool
