#include "tools/sft/bridge_claims.h"

#include <sft/msg_text.h>

#include <algorithm>
#include <nlohmann/json.hpp>
#include <tuple>

namespace sft::tool {

namespace {

using namespace std::chrono_literals;

constexpr const char* claims_definition =
    "uint64 bridge\nsft_bridge/Claim[] claims\n===\nMSG: sft_bridge/Claim\nuint64 origin\nuint32 bridges\n"
    "string topic\nuint64 publisher\n";
/// Another bridge that has just started, too, hears of a claim within this time.
constexpr auto claim_time = 1s;
/// After this time all bridges that were there before are known.
constexpr auto discovery_time = 3s;
/// So long the claims of a bridge that is there are waited for.
constexpr auto hearing_time = 5s;
/// After an outage of the network a bridge does not tell again what it has told before.
constexpr auto memory_time = 1h;
constexpr std::uint32_t bridges_most = 64;   // in a chain
constexpr std::size_t claims_most = 16'384;  // of one bridge
constexpr std::size_t claims_bytes_most = 4 << 20;

}  // namespace

Result<BridgeClaims> BridgeClaims::open(Node& node, std::uint64_t bridge) {
  const Result<DynamicType> type = from_msg("sft_bridge/Claims", claims_definition);
  if (!type) return tl::unexpected(type.error());
  const std::string topic = std::string("/") + bridge_topic;
  Result<DynamicPublisher> publisher = node.publisher(
      topic, *type,
      {.reliability = reliable, .durability = transient_local, .max_sample_bytes = claims_bytes_most});
  if (!publisher) return tl::unexpected(publisher.error());
  Result<DynamicSubscriber> subscriber =
      node.subscriber(topic, *type, "*", {.reliability = reliable, .durability = transient_local});
  if (!subscriber) return tl::unexpected(subscriber.error());
  return BridgeClaims(bridge, *std::move(publisher), *std::move(subscriber));
}

void BridgeClaims::look(const DomainSnapshot& domain, Time now) {
  while (const DynamicSample sample = subscriber_.take()) {
    const Result<std::string> text = sample.to_json();
    const auto json = nlohmann::json::parse(text ? *text : "", nullptr, false);
    if (json.is_discarded() || json["claims"].size() > claims_most) continue;
    Other& other = others_[sample.info().writer];
    other = {.bridge = json["bridge"].get<std::uint64_t>(), .heard = now, .seen = other.seen};
    for (const auto& claim : json["claims"]) {
      if (claim["bridges"].get<std::uint32_t>() > bridges_most) continue;
      other.claims.push_back({.origin = claim["origin"].get<std::uint64_t>(),
                              .bridges = claim["bridges"].get<std::uint32_t>(),
                              .topic = claim["topic"].get<std::string>(),
                              .publisher = claim["publisher"].get<std::uint64_t>()});
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

std::optional<BridgeClaims::Source> BridgeClaims::source_of(const DomainSnapshot::Endpoint& publisher) const {
  for (const auto& [id, other] : others_) {
    if (!other.is_there) continue;
    const auto claim = std::ranges::find_if(
        other.claims, [&](const Claim& one) { return one.publisher == publisher.id && one.bridges > 0; });
    if (claim != other.claims.end()) return Source{claim->origin, claim->bridges};
  }
  if (publisher.node.starts_with(bridge_node_prefix)) return std::nullopt;
  return Source{publisher.id, 0};
}

BridgeClaims::Verdict BridgeClaims::verdict(const Source& source, const std::string& topic, Time now) const {
  const auto is_here = [&](const Claim& claim) {
    return claim.bridges == 0 && claim.origin == source.origin;
  };
  if (publishers_.contains(source.origin) || std::ranges::any_of(told_, is_here))
    return Verdict::belongs_there;
  const std::uint32_t bridges = source.bridges + 1;
  const bool is_carried = std::ranges::any_of(told_, [&](const Claim& own) {
    return own.origin == source.origin && own.topic == topic && own.publisher != 0;
  });
  for (const auto& [id, other] : others_) {
    if (!other.is_there) continue;
    if (std::ranges::any_of(other.claims, is_here)) return Verdict::belongs_there;
    for (const Claim& claim : other.claims) {
      if (claim.origin != source.origin || claim.topic != topic) continue;
      // One whose claim does not hold any more ends as soon as it hears of this one.
      if ((claim.publisher != 0 && !is_carried) ||
          std::tie(claim.bridges, other.bridge) < std::tie(bridges, bridge_))
        return Verdict::held_by_another;
    }
  }
  return is_settled(source, topic, now) ? Verdict::holds : Verdict::settles;
}

bool BridgeClaims::is_settled(const Source& source, const std::string& topic, Time now) const {
  const auto since = since_.find({source.origin, topic});
  if (since == since_.end()) return false;
  const auto is_awaited = [&](const auto& one) { return now - one.second < hearing_time; };
  if (std::ranges::any_of(unheard_, is_awaited)) return false;
  const bool has_others =
      !unheard_.empty() || std::ranges::any_of(others_, [](const auto& one) { return one.second.is_there; });
  const bool is_alone = !has_others && now - opened_ > discovery_time;
  return is_alone || now - since->second >= claim_time;
}

void BridgeClaims::tell(std::vector<Claim> claims, Time now) {
  std::ranges::sort(claims);
  if (claims == told_) return;
  nlohmann::json list = nlohmann::json::array();
  std::map<std::pair<std::uint64_t, std::string>, Time> since;
  for (const Claim& claim : claims) {
    list.push_back({{"origin", claim.origin},
                    {"bridges", claim.bridges},
                    {"topic", claim.topic},
                    {"publisher", claim.publisher}});
    if (claim.bridges == 0) continue;
    const std::pair key(claim.origin, claim.topic);
    const auto known = since_.find(key);
    since.emplace(key, known == since_.end() ? now : known->second);
  }
  const nlohmann::json message{{"bridge", bridge_}, {"claims", std::move(list)}};
  if (!publisher_.publish_json(message.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace)))
    return;
  told_ = std::move(claims);
  since_ = std::move(since);
}

}  // namespace sft::tool
