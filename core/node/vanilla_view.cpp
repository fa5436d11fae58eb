#include "core/node/vanilla_view.h"

#include <algorithm>
#include <iterator>
#include <map>
#include <optional>
#include <string>
#include <tuple>
#include <utility>

#include "core/names/names.h"
#include "core/names/qos.h"
#include "core/vanilla/dds_names.h"
#include "core/vanilla/type_hash.h"
#include "core/vanilla/vanilla_matching.h"
#include "sft/detail/fnv1a.h"

namespace sft::core {

namespace {

using EndpointInfo = DomainSnapshot::Endpoint;

/// Returns the name of the endpoint's node. If the node is unknown, returns that of the participant, since
/// DDS itself knows no nodes.
const std::string& node_of(const VanillaEndpoint& endpoint) {
  return endpoint.node.empty() ? endpoint.participant : endpoint.node;
}

/// Returns the name of the topic in SFT, or nothing if nodes of SFT cannot have such a topic or type. This
/// is the only check of the names that DDS announces, which are shown to users.
std::optional<std::string> topic_of(const VanillaEndpoints::OfTopic& one, DdsNames names) {
  std::optional<std::string> topic = topic_of_dds(one.topic, names);
  const bool is_sound =
      topic && fault_of_announced_topic(*topic).empty() && fault_of_name(one.endpoint.type_name).empty();
  return is_sound ? topic : std::nullopt;
}

std::string if_sound(const std::string& text) { return fault_of_name(text).empty() ? text : ""; }

EndpointInfo vanilla_info_of(const VanillaEndpoints::OfTopic& one, std::string topic, DdsNames names) {
  const VanillaEndpoint& endpoint = one.endpoint;
  detail::Fnv1a node;
  node.add(endpoint.participant);
  EndpointInfo info{.id = endpoint.id,
                    .node_id = node.value(),
                    .node = node_of(endpoint),
                    .topic = std::move(topic),
                    .type_name = type_of_dds(endpoint.type_name, names),
                    .qos = endpoint.qos,
                    .dds = DomainSnapshot::Dds{.guid = endpoint.guid,
                                               .topic = one.topic,
                                               .type_name = endpoint.type_name,
                                               .type_hash = endpoint.type_hash}};
  info.qos.history_depth = 0;
  return info;
}

/// Returns the hash of the endpoint's type if the other endpoint has a hash, otherwise an empty text.
std::string hash_of(const EndpointInfo& endpoint, const VanillaEndpoint& other) {
  return endpoint.type && !other.type_hash.empty() ? sft::ros_type_hash(*endpoint.type).value_or("") : "";
}

/// Returns the reason why a pair is not connected. A node that has no DDS endpoint for a DDS node writes
/// the exact reason only to its log.
std::string not_connected(const std::string& whose, const char* what) {
  return "the node of the " + whose + " has no DDS " + what +
         " for it: it has not found the DDS node yet, or rules DDS nodes out (its options, SFT_VANILLA_DDS), "
         "or leaves them alone because its program speaks DDS itself (its log says so)";
}

/// Returns the state of a publisher of SFT and a reader of DDS, by the rules of the publisher's node.
DomainSnapshot::Pair pair_of(const EndpointInfo& publisher, const VanillaEndpoint& reader,
                             const VanillaView& view) {
  const std::string type_name = dds_type(publisher.type_name, view.names);
  const std::string why_not = why_not_served(type_name, offered_to_vanilla(publisher.qos), reader);
  DomainSnapshot::Pair pair{.publisher = publisher.id, .subscriber = reader.id, .dds_subscriber = true};
  pair.matched = why_not.empty();
  pair.connected = pair.matched && view.of_sft.contains(publisher.id);
  pair.reason = "it knows nothing of SFT, and gets whole messages";
  if (view.unanswered.contains(publisher.id)) {
    pair.reason +=
        "; this reader, or another one of DDS, does not acknowledge what the publisher sends: it is stopped "
        "or "
        "too slow, or a firewall drops its answers";
  }
  if (!pair.connected) pair.reason = pair.matched ? not_connected("publisher", "writer") : why_not;
  pair.incompatible_type = reader.type_name != type_name;
  pair.incompatible_policy = conflict_between(offered_to_vanilla(publisher.qos), reader.qos).policy;
  const std::string other = difference_of_hashes(hash_of(publisher, reader), "publisher", reader);
  if (!other.empty()) pair.reason += "; " + other + ", so it misreads what it gets";
  return pair;
}

/// Returns the state of a writer of DDS and a subscriber of SFT, by the rules of the subscriber's node.
DomainSnapshot::Pair pair_of(const VanillaEndpoint& writer, const EndpointInfo& subscriber,
                             const VanillaView& view) {
  const std::string type_name = dds_type(subscriber.type_name, view.names),
                    type_hash = hash_of(subscriber, writer);
  const Qos requested = requested_from_vanilla(subscriber.qos);
  const std::string why_not = why_not_heard(type_name, type_hash, requested, writer);
  DomainSnapshot::Pair pair{.publisher = writer.id, .subscriber = subscriber.id, .dds_publisher = true};
  pair.matched = why_not.empty();
  pair.connected = pair.matched && view.of_sft.contains(subscriber.id);
  pair.reason =
      "it knows nothing of SFT, and sends whole messages; fields, conditions and rates are applied at the "
      "subscriber";
  if (!pair.connected) pair.reason = pair.matched ? not_connected("subscriber", "reader") : why_not;
  pair.incompatible_type =
      writer.type_name != type_name || !difference_of_hashes(type_hash, "subscriber", writer).empty();
  pair.incompatible_policy = conflict_between(writer.qos, requested).policy;
  if (pair.matched && writer.type_hash.empty())
    pair.reason += "; unverified: it announces no hash of its definition";
  return pair;
}

void sort_by_topic(std::vector<EndpointInfo>& endpoints) {
  std::ranges::sort(endpoints, {}, [](const EndpointInfo& e) { return std::tie(e.topic, e.node, e.id); });
}

void add_nodes(DomainSnapshot& snapshot, const VanillaView& view) {
  std::map<std::string, std::size_t> endpoints;
  for (const auto* all : {&view.readers, &view.writers})
    for (const VanillaEndpoints::OfTopic& one : *all) ++endpoints[one.endpoint.participant];
  for (const VanillaParticipant& one : view.participants) {
    snapshot.dds_nodes.push_back({.name = one.name,
                                  .host = if_sound(one.host),
                                  .process = if_sound(one.process),
                                  .endpoints = endpoints[one.name]});
  }
}

}  // namespace

void add_vanilla(DomainSnapshot& snapshot, const VanillaView& view, const PairAccounts& accounts) {
  std::vector<EndpointInfo> publishers, subscribers;
  const auto add = [&](DomainSnapshot::Pair pair) {
    pair.transport = TransportKind::dds;
    const auto reported = accounts.find({pair.publisher, pair.subscriber});
    if (reported != accounts.end()) pair.account = reported->second;
    snapshot.pairs.push_back(std::move(pair));
  };
  for (const VanillaEndpoints::OfTopic& one : view.writers) {
    const std::optional<std::string> topic = topic_of(one, view.names);
    if (!topic) continue;
    publishers.push_back(vanilla_info_of(one, *topic, view.names));
    for (const EndpointInfo& subscriber : snapshot.subscribers)
      if (subscriber.topic == *topic) add(pair_of(one.endpoint, subscriber, view));
  }
  for (const VanillaEndpoints::OfTopic& one : view.readers) {
    const std::optional<std::string> topic = topic_of(one, view.names);
    if (!topic) continue;
    subscribers.push_back(vanilla_info_of(one, *topic, view.names));
    subscribers.back().fields = "*";
    for (const EndpointInfo& publisher : snapshot.publishers)
      if (publisher.topic == *topic) add(pair_of(publisher, one.endpoint, view));
  }
  std::ranges::move(publishers, std::back_inserter(snapshot.publishers));
  std::ranges::move(subscribers, std::back_inserter(snapshot.subscribers));
  sort_by_topic(snapshot.publishers);
  sort_by_topic(snapshot.subscribers);
  add_nodes(snapshot, view);
}

}  // namespace sft::core
