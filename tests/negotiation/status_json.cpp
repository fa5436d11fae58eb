#include "tests/negotiation/status_json.h"

#include "tests/negotiation/message.h"

namespace sft::test {

using nlohmann::json;

namespace {

/// What readers and writers have in common.
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

json to_json(const PublisherStatus& status) {
  json readers = json::array();
  for (const ReaderStatus& r : status.readers) {
    readers.push_back(peer_json(r));
    readers.back().update({{"served", r.served},
                           {"mask", to_string<PointCloud2>(r.mask)},
                           {"max_rate_hz", r.max_rate_hz},
                           {"request", r.request_sequence}});
  }
  return {{"published", status.published},
          {"dropped", status.dropped},
          {"bytes_sent", status.bytes_sent},
          {"readers", std::move(readers)}};
}

json to_json(const SubscriberStatus& status) {
  json writers = json::array();
  for (const WriterStatus& w : status.writers) {
    writers.push_back(peer_json(w));
    writers.back().update({{"matched", w.matched},
                           {"alive", w.alive},
                           {"received", w.received},
                           {"lost", w.lost},
                           {"expired", w.expired}});
  }
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
          {"control_ignored", status.control_ignored}};
}

json to_json(const Event& event) {
  return {{"kind", to_string(event.kind)},
          {"node", event.node},
          {"policy", to_string(event.policy)},
          {"text", event.text}};
}

}  // namespace sft::test
