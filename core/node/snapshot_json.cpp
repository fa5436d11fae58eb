// The names in the JSON text are documented in sft/snapshot.h, and must not change.
#include <nlohmann/json.hpp>

#include "core/platform/random_id.h"
#include "sft/snapshot.h"

namespace sft {

namespace {

using Json = nlohmann::ordered_json;

Json qos_of(const Qos& qos) {
  return {{"reliability", to_string(qos.reliability)},
          {"durability", to_string(qos.durability)},
          {"history_depth", qos.history_depth},
          {"deadline_ns", qos.deadline.count()},
          {"lifespan_ns", qos.lifespan.count()},
          {"liveliness", to_string(qos.liveliness)},
          {"liveliness_lease_ns", qos.liveliness_lease.count()}};
}

Json policy(QosPolicy policy) { return policy == QosPolicy::none ? Json() : Json(to_string(policy)); }

Json path(bool travels, TransportKind kind) { return travels ? Json(to_string(kind)) : Json(); }

template <class Item>
Json list(const std::vector<Item>& items, Json (*one)(const Item&)) {
  Json array = Json::array();
  for (const Item& item : items) array.push_back(one(item));
  return array;
}

Json reader(const NodeSnapshot::Publisher::Reader& r) {
  return {{"id", core::in_hex(r.id)},
          {"node", r.node},
          {"served", r.served},
          {"transport", path(r.served, r.transport)},
          {"reason", r.reason},
          {"multicast", r.multicast},
          {"incompatible_type", r.incompatible_type},
          {"incompatible_policy", policy(r.incompatible_policy)},
          {"no_path", r.no_path},
          {"fields", r.fields},
          {"max_rate_hz", r.max_rate_hz},
          {"request", r.request_sequence},
          {"published", r.published},
          {"sent", r.sent},
          {"withheld", r.withheld},
          {"dropped", r.dropped},
          {"retained", r.retained},
          {"diverted", r.diverted},
          {"bytes_sent", r.bytes_sent},
          {"bytes_saved", r.bytes_saved}};
}

Json publisher(const NodeSnapshot::Publisher& p) {
  return {{"id", core::in_hex(p.id)},
          {"topic", p.topic},
          {"type", p.type},
          {"qos", qos_of(p.qos)},
          {"fields", p.fields},
          {"published", p.published},
          {"bytes_sent", p.bytes_sent},
          {"bytes_saved", p.bytes_saved},
          {"dropped", p.dropped},
          {"diverted",
           {{"exhausted", p.diverted.exhausted},
            {"too_large", p.diverted.too_large},
            {"unavailable", p.diverted.unavailable},
            {"too_large_bytes", p.diverted.too_large_bytes},
            {"chunk_bytes", p.diverted.chunk_bytes}}},
          {"vanilla_readers", p.vanilla_readers},
          {"deadlines_missed", p.deadlines_missed},
          {"alive", p.alive},
          {"readers", list(p.readers, reader)}};
}

Json writer(const SubscriberStatus::Writer& w) {
  return {{"id", core::in_hex(w.id)},
          {"node", w.node},
          {"matched", w.matched},
          {"connected", w.connected},
          {"alive", w.alive},
          {"transport", path(w.connected, w.transport)},
          {"reason", w.reason},
          {"depth", w.depth},
          {"incompatible_type", w.incompatible_type},
          {"incompatible_policy", policy(w.incompatible_policy)},
          {"no_path", w.no_path},
          {"received", w.received},
          {"lost", w.lost},
          {"withheld", w.withheld},
          {"expired", w.expired},
          {"deadlines_missed", w.deadlines_missed},
          {"restarts", w.restarts}};
}

Json subscriber(const NodeSnapshot::Subscriber& s) {
  return {{"id", core::in_hex(s.id)},
          {"topic", s.topic},
          {"selection", s.selection_number},
          {"type", s.type},
          {"qos", qos_of(s.qos)},
          {"fields", s.fields},
          {"recorded", s.recorded},
          {"max_rate_hz", s.max_rate_hz},
          {"requests", s.requests},
          {"received", s.received},
          {"lost", s.lost},
          {"withheld", s.withheld},
          {"expired", s.expired},
          {"discarded", s.discarded},
          {"held_too_many", s.held_too_many},
          {"long_waits", s.long_waits},
          {"restarts", s.restarts},
          {"writers", list(s.writers, writer)}};
}

Json node(const NodeSnapshot& s) {
  return {{"name", s.name},
          {"domain", s.domain},
          {"version", s.version},
          {"control_protocol", s.control_protocol},
          {"time_ns", s.time.time_since_epoch().count()}};
}

Json shm(const NodeStatus& s) {
  return {{"ready", s.shm_ready},
          {"state", s.shm},
          {"refused", {{"malformed", s.shm_samples_malformed}, {"over_limit", s.shm_over_limit}}}};
}

Json quick_paths(const NodeStatus& s) {
  Json paths = Json::object();
  for (const NodeStatus::QuickPath& path : s.quick_paths)
    paths[path.name] = path.why_not.empty() ? "used" : "not used: " + path.why_not;
  return paths;
}

Json udp(const NodeStatus& s) {
  return {{"state", s.udp},
          {"quick_paths", quick_paths(s)},
          {"refused",
           {{"malformed", s.datagrams_malformed},
            {"unknown", s.datagrams_unknown},
            {"incomplete", s.samples_incomplete},
            {"over_limit", s.over_limit}}}};
}

Json control(const NodeStatus& s) {
  return {{"links_renewed", s.links_renewed},
          {"refused", {{"malformed", s.control_malformed}, {"ignored", s.control_ignored}}}};
}

}  // namespace

std::string to_json(const Qos& qos) { return qos_of(qos).dump(); }

std::string to_json(const NodeSnapshot& snapshot, int indent) {
  const Json json = {{"node", node(snapshot)},
                     {"shm", shm(snapshot.status)},
                     {"udp", udp(snapshot.status)},
                     {"control", control(snapshot.status)},
                     {"publishers", list(snapshot.publishers, publisher)},
                     {"subscribers", list(snapshot.subscribers, subscriber)}};
  return json.dump(indent, ' ', false, Json::error_handler_t::replace);
}

}  // namespace sft
