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
/// Within this time a bridge receives the routes of other bridges that start at the same time.
constexpr auto settling_time = 1s;
/// Within this time after its start a bridge discovers all bridges that were started earlier.
constexpr auto discovery_time = 3s;
/// The time for which a bridge waits for the routes of a bridge that it has discovered.
constexpr auto hearing_time = 5s;
/// The time for which the routes of bridges are kept after they are gone. After an outage of the network, a
/// bridge does not announce its old routes again.
constexpr auto memory_time = 1h;
constexpr std::uint32_t bridges_most = 64;  // the maximum length of a chain of bridges
/// Routes are announced again after this time. Long lists are announced less often, so that repetitions use
/// at most 8 kB per second of a link.
constexpr auto repetition_time = 2s;
constexpr std::size_t repeated_bytes_per_ms = 8;
// Limits of the routes that other bridges announce, since any node may announce itself as a bridge.
constexpr std::size_t routes_most = 4'096, routes_bytes_most = 256 << 10;  // limits per bridge
constexpr std::size_t routes_of_all_most = 16'384, others_most = 256;
constexpr std::size_t topic_bytes_most = 255;

std::chrono::milliseconds time_until_repetition(const std::vector<BridgeRoutes::Route>& routes) {
  std::size_t bytes = 0;
  for (const BridgeRoutes::Route& route : routes) bytes += sizeof route + route.topic.size();
  return std::max<std::chrono::milliseconds>(repetition_time,
                                             std::chrono::milliseconds(bytes / repeated_bytes_per_ms));
}

}  // namespace

Result<BridgeRoutes> BridgeRoutes::open(Node& node, std::uint64_t bridge) {
  const Result<DynamicType> type = from_msg("sft_bridge/Routes", routes_definition);
  if (!type) return tl::unexpected(type.error());
  const std::string topic = std::string("/") + bridge_topic;
  Result<DynamicPublisher> publisher = node.publisher(
      topic, *type,
      {.reliability = reliable, .durability = transient_local, .max_sample_bytes = routes_bytes_most});
  if (!publisher) return tl::unexpected(publisher.error());
  Result<DynamicSubscriber> subscriber = node.subscriber(
      topic, *type, "*",
      {.reliability = reliable, .durability = transient_local, .depth = 8, .depth_bytes = routes_bytes_most});
  if (!subscriber) return tl::unexpected(subscriber.error());
  BridgeRoutes routes(bridge, *std::move(publisher), *std::move(subscriber));
  if (const Result<void> said = routes.publish({}); !said) return tl::unexpected(said.error());
  return routes;
}

/// Reads the announcements of other bridges. Reads only some of them in a call, so that very many
/// announcements do not delay samples.
void BridgeRoutes::hear(Time now) {
  for (std::size_t bytes = 0; bytes < routes_bytes_most;) {
    const DynamicSample sample = subscriber_.take();
    if (!sample) return;
    bytes += sample.cdr().size();
    if (sample.cdr().size() > routes_bytes_most || sample.info().writer == own_id_) continue;
    const Result<std::string> text = sample.to_json();
    const auto json = nlohmann::json::parse(text ? *text : "", nullptr, false);
    if (json.is_discarded() || json["routes"].size() > routes_most) continue;
    Other& other = others_[sample.info().writer];
    other = {
        .bridge = json["bridge"].get<std::uint64_t>(), .node = other.node, .heard = now, .seen = other.seen};
    for (const auto& route : json["routes"]) {
      Route one{.origin = route["origin"].get<std::uint64_t>(),
                .bridges = route["bridges"].get<std::uint32_t>(),
                .topic = route["topic"].get<std::string>(),
                .publisher = route["publisher"].get<std::uint64_t>()};
      if (one.bridges <= bridges_most && one.topic.size() <= topic_bytes_most)
        other.routes.push_back(std::move(one));
    }
  }
}

void BridgeRoutes::look(const DomainSnapshot& domain, Time now) {
  hear(now);
  publishers_.clear();
  std::map<std::uint64_t, Time> unheard;
  for (const DomainSnapshot::Endpoint& publisher : domain.publishers) {
    publishers_.insert(publisher.id);
    if (publisher.is_own || publisher.topic != bridge_topic) continue;
    if (const auto other = others_.find(publisher.id); other != others_.end()) {
      other->second.node = publisher.node_id;
      other->second.seen = now;
      continue;
    }
    const auto known = unheard_.find(publisher.id);
    unheard.emplace(publisher.id, known == unheard_.end() ? now : known->second);
  }
  unheard_ = std::move(unheard);
  for (auto& [id, other] : others_) {
    const bool is_awaited = other.seen == Time{} && now - other.heard < hearing_time;
    other.is_there = is_awaited || other.seen == now;
  }
  forget(now);
}

/// Removes bridges that have been gone for longer than memory_time. If the limits are still exceeded,
/// removes further bridges: first those that are gone, then those with the most routes.
void BridgeRoutes::forget(Time now) {
  std::erase_if(others_, [&](const auto& one) {
    return now - std::max(one.second.seen, one.second.heard) > memory_time;
  });
  std::size_t routes = 0;
  for (const auto& [id, other] : others_) routes += other.routes.size();
  while (others_.size() > others_most || routes > routes_of_all_most) {
    const auto most = std::ranges::max_element(others_, {}, [](const auto& one) {
      return std::pair(!one.second.is_there, one.second.routes.size());
    });
    routes -= most->second.routes.size();
    others_.erase(most);
  }
}

std::optional<BridgeRoutes::Source> BridgeRoutes::source_of(const DomainSnapshot::Endpoint& publisher) const {
  for (const auto& [id, other] : others_) {
    // A bridge announces only routes of its own publishers.
    if (!other.is_there || other.node != publisher.node_id) continue;
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
  // A route in use is not interrupted by bridges that start later.
  return is_carried || is_settled(source, topic, now) ? Verdict::holds : Verdict::settles;
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

Result<void> BridgeRoutes::publish(const std::vector<Route>& routes) {
  nlohmann::json list = nlohmann::json::array();
  for (const Route& route : routes) {
    list.push_back({{"origin", route.origin},
                    {"bridges", route.bridges},
                    {"topic", route.topic},
                    {"publisher", route.publisher}});
  }
  const nlohmann::json message{{"bridge", bridge_}, {"routes", std::move(list)}};
  const Result<PublishStatus> done =
      publisher_.publish_json(message.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
  return done ? Result<void>() : tl::unexpected(done.error());
}

void BridgeRoutes::announce(std::vector<Route> routes, Time now) {
  std::ranges::sort(routes);
  if ((routes == announced_ && now < announced_again_at_) || !publish(routes)) return;
  announced_again_at_ = now + time_until_repetition(routes);
  std::map<std::pair<std::uint64_t, std::string>, Time> since;
  for (const Route& route : routes) {
    if (route.bridges == 0) continue;
    const std::pair key(route.origin, route.topic);
    const auto known = since_.find(key);
    since.emplace(key, known == since_.end() ? now : known->second);
  }
  announced_ = std::move(routes);
  since_ = std::move(since);
}

}  // namespace sft::tool
