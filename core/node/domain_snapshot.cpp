#include "core/node/domain_snapshot.h"

#include <algorithm>
#include <map>
#include <string>
#include <tuple>
#include <utility>

#include "core/control/described_type.h"
#include "core/negotiation/pair.h"
#include "core/negotiation/requested_selection.h"
#include "core/platform/ip_address.h"
#include "core/platform/network_id.h"

namespace sft::core {

namespace {

/// The types that endpoints describe. Each description is decoded once.
class Types {
 public:
  const std::optional<DynamicType>& of(const Endpoint& endpoint) {
    std::optional<DynamicType>& type = types_[{endpoint.type_name, endpoint.type_hash}];
    if (!type) {
      if (Result<DynamicType> described = described_type(endpoint)) type = *std::move(described);
    }
    return type;
  }

 private:
  std::map<std::pair<std::string, std::uint64_t>, std::optional<DynamicType>> types_;
};

std::string fields_of(const Request& request, const TypeSupport& type) {
  const Result<Selection> asked = requested_selection(request, type);
  return asked ? type.format_selection(*asked) : std::string();
}

DomainSnapshot::Endpoint info_of(const TableEntry& known, Types& types, NodeId id, std::uint64_t network) {
  const Endpoint& e = known.endpoint;
  DomainSnapshot::Endpoint info{.id = e.id,
                                .node_id = e.node_id,
                                .node = e.node,
                                .is_own = e.node_id == id,
                                .topic = e.topic,
                                .given_topic = e.given_topic,
                                .type_name = e.type_name,
                                .type_hash = e.type_hash,
                                .type = types.of(e),
                                .qos = e.qos,
                                .may_use_shm = e.may_use_memory,
                                .may_use_udp = e.may_use_network,
                                .shm_ready = e.may_use_memory && e.host.known(),
                                .same_machine = on_one_machine(e.network, network)};
  for (const UdpAddress& address : e.addresses) info.addresses.push_back(format(address.ip, address.port));
  if (e.role == Role::writer) {
    info.max_sample_bytes = e.max_sample_bytes;
    info.waits = e.waits;
    if (known.progress) info.progress = {known.progress->samples, known.progress->bytes};
    return info;
  }
  if (info.type) info.fields = fields_of(e.request, info.type->support());
  info.max_rate_hz = e.request.min_period_us == 0 ? 0 : 1e6 / e.request.min_period_us;
  info.requests = e.request.sequence;
  return info;
}

/// Returns the state of the pair, by the same rules as the writer's node.
DomainSnapshot::Pair pair_info(const Endpoint& writer, const Endpoint& reader,
                               const std::optional<DynamicType>& type, TypeComparisons& comparisons) {
  static const StructType no_members;
  static const TypeSupport unknown(no_members);
  const Self self{.host = writer.host,
                  .network = writer.network,
                  .memory_state = writer.memory_failure.empty()
                                      ? "the publisher's node has none yet"
                                      : "the publisher's node: " + writer.memory_failure};
  const Verdict verdict =
      evaluate({writer, reader, true}, type ? type->support() : unknown, self, type ? &comparisons : nullptr);
  const bool durable = writer.qos.durability == Durability::transient_local &&
                       reader.qos.durability == Durability::transient_local;
  const bool begun = std::ranges::find(reader.request.begun, writer.id) != reader.request.begun.end();
  SubscriberStatus::Writer status =
      heard_as(writer, true, reader, verdict, durable && verdict.network && !begun);
  return {.publisher = writer.id,
          .subscriber = reader.id,
          .matched = status.matched,
          .connected = status.connected,
          .transport = status.transport,
          .reason = std::move(status.reason),
          .incompatible_type = status.incompatible_type,
          .mismatch = std::move(status.mismatch),
          .incompatible_policy = status.incompatible_policy,
          .no_path = status.no_path};
}

}  // namespace

DomainSnapshot domain_snapshot(std::vector<TableEntry> endpoints, const PairAccounts& accounts, NodeId id,
                               std::uint64_t network) {
  std::ranges::sort(endpoints, {}, [](const TableEntry& k) {
    return std::tie(k.endpoint.topic, k.endpoint.node, k.endpoint.id);
  });
  DomainSnapshot snapshot;
  Types types;
  TypeComparisons comparisons;
  for (const TableEntry& known : endpoints) {
    const bool writes = known.endpoint.role == Role::writer;
    (writes ? snapshot.publishers : snapshot.subscribers).push_back(info_of(known, types, id, network));
  }
  for (const TableEntry& one : endpoints) {
    const Endpoint& writer = one.endpoint;
    if (writer.role != Role::writer) continue;
    for (const TableEntry& other : endpoints) {
      const Endpoint& reader = other.endpoint;
      if (reader.role != Role::reader || reader.topic != writer.topic) continue;
      DomainSnapshot::Pair& pair =
          snapshot.pairs.emplace_back(pair_info(writer, reader, types.of(writer), comparisons));
      if (const auto reported = accounts.find({writer.id, reader.id}); reported != accounts.end())
        pair.account = reported->second;
    }
  }
  return snapshot;
}

}  // namespace sft::core
