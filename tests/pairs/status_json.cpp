#include "tests/pairs/status_json.h"

#include "tests/pairs/message.h"

namespace sft::test {

using nlohmann::json;

namespace {

/// Returns the fields that the entries of readers and writers have in common.
template <class Peer>
json peer_json(const Peer& peer) {
  return {{"id", peer.id},
          {"node", peer.node},
          {"transport", to_string(peer.transport)},
          {"reason", peer.reason},
          {"policy", to_string(peer.incompatible_policy)},
          {"incompatible_type", peer.incompatible_type},
          {"withheld", peer.withheld}};
}

}  // namespace

json to_json(const PublisherStatus::Reader& reader) {
  json entry = peer_json(reader);
  entry.update({{"served", reader.served},
                {"mask", to_string<PointCloud2>(reader.mask)},
                {"dropped", reader.dropped},
                {"max_rate_hz", reader.max_rate_hz},
                {"request", reader.request_sequence}});
  return entry;
}

json to_json(const SubscriberStatus::Writer& writer) {
  json entry = peer_json(writer);
  entry.update({{"matched", writer.matched},
                {"alive", writer.alive},
                {"received", writer.received},
                {"lost", writer.lost},
                {"expired", writer.expired}});
  return entry;
}

json to_json(const PublisherStatus& status) {
  json readers = json::array();
  for (const PublisherStatus::Reader& reader : status.readers) readers.push_back(to_json(reader));
  return {{"published", status.published},
          {"dropped", status.dropped},
          {"bytes_sent", status.bytes_sent},
          {"readers", std::move(readers)}};
}

json to_json(const SubscriberStatus& status) {
  json writers = json::array();
  for (const SubscriberStatus::Writer& writer : status.writers) writers.push_back(to_json(writer));
  return {{"received", status.received}, {"lost", status.lost},
          {"withheld", status.withheld}, {"mask", to_string<PointCloud2>(status.mask)},
          {"requests", status.requests}, {"writers", std::move(writers)}};
}

json to_json(const NodeStatus& status) {
  return {{"shm_ready", status.shm_ready},
          {"shm", status.shm},
          {"datagrams_malformed", status.datagrams_malformed},
          {"datagrams_unknown", status.datagrams_unknown},
          {"control_malformed", status.control_malformed},
          {"links_renewed", status.links_renewed},
          {"control_ignored", status.control_ignored}};
}

json to_json(const Event& event) {
  return {{"kind", to_string(event.kind)},
          {"node", event.node},
          {"policy", to_string(event.policy)},
          {"text", event.text}};
}

}  // namespace sft::test
