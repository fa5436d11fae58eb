#include "tools/sft/describe.h"

#include <fmt/format.h>
#include <sft/snapshot.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "tools/sft/account_text.h"
#include "tools/sft/msg_text.h"
#include "tools/terminal/units.h"

namespace sft::tool {

namespace {

using Json = nlohmann::ordered_json;

double in_seconds(std::chrono::nanoseconds duration) {
  return std::chrono::duration<double>(duration).count();
}

void append_duration(std::string& text, const char* name, std::chrono::nanoseconds duration) {
  if (duration.count() != 0) text += fmt::format(", {} {}", name, duration_text(in_seconds(duration)));
}

Json qos_json(const Qos& qos) { return Json::parse(to_json(qos)); }

Json dds_json(const DomainSnapshot::Endpoint& e) {
  if (!e.dds) return nullptr;
  return {{"guid", e.dds->guid},
          {"topic", e.dds->topic},
          {"type", e.dds->type_name},
          {"type_hash", e.dds->type_hash.empty() ? Json() : Json(e.dds->type_hash)}};
}

Json progress_json(const DomainSnapshot::Endpoint& publisher) {
  if (!publisher.progress) return nullptr;
  return {{"samples", publisher.progress->samples}, {"bytes", publisher.progress->bytes}};
}

template <class Account>
Json count_of(const std::optional<Account>& account, std::uint64_t Account::*count) {
  return account ? Json(*account.*count) : Json();
}

template <class Account>
Json age_json(const std::optional<Account>& account) {
  return account ? Json(account->age.count()) : Json();
}

}  // namespace

Json endpoint_json(const DomainSnapshot::Endpoint& e, bool publishes) {
  Json json = {{"id", hex_text(e.id)},
               {"role", publishes ? "publisher" : "subscriber"},
               {"node", e.node},
               {"node_id", hex_text(e.node_id)},
               {"topic", e.topic},
               {"given_topic", e.given_topic.empty() ? Json() : Json(e.given_topic)},
               {"type", ros_name(e.type_name)},
               {"type_hash", hex_text(e.type_hash)},
               {"type_described", e.type.has_value()},
               {"qos", qos_json(e.qos)},
               {"may_use_shm", e.may_use_shm},
               {"may_use_udp", e.may_use_udp},
               {"shm_ready", e.shm_ready},
               {"same_machine", e.same_machine},
               {"addresses", e.addresses},
               {"dds", dds_json(e)}};
  if (publishes) {
    json["max_sample_bytes"] = e.max_sample_bytes;
    json["waits"] = e.waits;
    json["sent"] = progress_json(e);
  } else {
    json["fields"] = e.fields ? Json(*e.fields) : Json();
    json["max_rate_hz"] = e.max_rate_hz;
    json["requests"] = e.requests;
  }
  return json;
}

Json pair_json(const DomainSnapshot::Pair& pair, const DomainSnapshot::Endpoint& publisher,
               const DomainSnapshot::Endpoint& subscriber) {
  const bool has_policy = pair.incompatible_policy != QosPolicy::none;
  return {{"publisher", {{"id", hex_text(pair.publisher)}, {"node", publisher.node}}},
          {"subscriber", {{"id", hex_text(pair.subscriber)}, {"node", subscriber.node}}},
          {"dds", pair.dds_publisher || pair.dds_subscriber},
          {"matched", pair.matched},
          {"connected", pair.connected},
          {"transport", pair.connected ? Json(to_string(pair.transport)) : Json()},
          {"reason", pair.reason},
          {"incompatible_type", pair.incompatible_type},
          {"difference", pair.mismatch ? Json(pair.mismatch->difference) : Json()},
          {"incompatible_policy", has_policy ? Json(to_string(pair.incompatible_policy)) : Json()},
          {"no_path", pair.no_path},
          {"fields", subscriber.fields ? Json(*subscriber.fields) : Json()},
          {"max_rate_hz", subscriber.max_rate_hz},
          {"offered", qos_json(publisher.qos)},
          {"requested", qos_json(subscriber.qos)},
          {"sent_by_publisher", progress_json(publisher)},
          {"sent", count_of(pair.account.publisher, &DomainSnapshot::Sent::sent)},
          {"bytes_sent", count_of(pair.account.publisher, &DomainSnapshot::Sent::bytes_sent)},
          {"bytes_saved", count_of(pair.account.publisher, &DomainSnapshot::Sent::bytes_saved)},
          {"withheld", count_of(pair.account.publisher, &DomainSnapshot::Sent::withheld)},
          {"dropped", count_of(pair.account.publisher, &DomainSnapshot::Sent::dropped)},
          {"retained", count_of(pair.account.publisher, &DomainSnapshot::Sent::retained)},
          {"diverted", count_of(pair.account.publisher, &DomainSnapshot::Sent::diverted)},
          {"too_large_bytes", count_of(pair.account.publisher, &DomainSnapshot::Sent::too_large_bytes)},
          {"chunk_bytes", count_of(pair.account.publisher, &DomainSnapshot::Sent::chunk_bytes)},
          {"publisher_told_ns_ago", age_json(pair.account.publisher)},
          {"received", count_of(pair.account.subscriber, &DomainSnapshot::Received::received)},
          {"lost", count_of(pair.account.subscriber, &DomainSnapshot::Received::lost)},
          {"takes_none", takes_none(pair)},
          {"subscriber_told_ns_ago", age_json(pair.account.subscriber)}};
}

std::string qos_text(const Qos& qos) {
  std::string text = fmt::format("{}, {}", to_string(qos.reliability), to_string(qos.durability));
  if (qos.history_depth > 0) text += fmt::format(", keep last {}", qos.history_depth);
  append_duration(text, "deadline", qos.deadline);
  append_duration(text, "lifespan", qos.lifespan);
  if (qos.liveliness != Liveliness::automatic) text += fmt::format(", {}", to_string(qos.liveliness));
  append_duration(text, "lease", qos.liveliness_lease);
  return text;
}

std::string request_text(const DomainSnapshot::Endpoint& subscriber) {
  std::string text = !subscriber.fields           ? "fields of a type that is not described"
                     : subscriber.fields->empty() ? "no field"
                     : *subscriber.fields == "*"  ? "all fields"
                                                  : *subscriber.fields;
  if (subscriber.max_rate_hz > 0) text += fmt::format("; at most {:.4g} Hz", subscriber.max_rate_hz);
  return text;
}

std::string ways_text(const DomainSnapshot::Endpoint& endpoint) {
  if (endpoint.dds) return "dds";
  const char* shm = endpoint.shm_ready ? "shm" : "shm (not ready)";
  if (endpoint.may_use_shm && endpoint.may_use_udp) return fmt::format("{}, udp", shm);
  return endpoint.may_use_shm ? shm : "udp";
}

std::string type_hash_text(const DomainSnapshot::Endpoint& endpoint) {
  if (!endpoint.dds) return hex_text(endpoint.type_hash);
  return endpoint.dds->type_hash.empty() ? "-" : endpoint.dds->type_hash;
}

std::string verdict_text(const DomainSnapshot::Pair& pair) {
  if (!pair.matched) return "not matched: " + pair.reason;
  if (!pair.connected) return "matched, not connected yet: " + pair.reason;
  return fmt::format("matched by {}: {}", to_string(pair.transport), pair.reason);
}

const DomainSnapshot::Endpoint* endpoint_of(std::uint64_t id,
                                            const std::vector<DomainSnapshot::Endpoint>& endpoints) {
  const auto found = std::ranges::find(endpoints, id, &DomainSnapshot::Endpoint::id);
  return found == endpoints.end() ? nullptr : &*found;
}

}  // namespace sft::tool
