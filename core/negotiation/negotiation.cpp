#include "core/negotiation/negotiation.h"

#include <optional>
#include <utility>

#include "core/negotiation/id_list.h"

namespace sft::core {

namespace {

/// Returns true if some endpoint of ours has the same topic.
bool is_of_our_topic(const EndpointTable& table, EndpointId id) {
  const Endpoint* const endpoint = table.known(id);
  return endpoint != nullptr && table.is_topic_of_ours(endpoint->topic);
}

/// Gives a changed request of ours a greater sequence.
bool renew(Request& request) {
  ++request.sequence;
  return true;
}

}  // namespace

bool Negotiation::self_changed(const Self& self) {
  const bool new_host = self.host != facts_.host.self().host;
  if (!facts_.host.self_changed(self)) return false;
  for (Endpoint* const ours : facts_.table.ours()) {
    facts_.host.equip(*ours);
    if (!new_host || ours->request.attached.empty()) continue;
    ours->request.attached.clear();
    renew(ours->request);
  }
  return true;
}

bool Negotiation::network_changed(const std::vector<UdpAddress>& addresses, const std::vector<Link>& links) {
  facts_.host.network_changed(addresses, links);
  for (Endpoint* const ours : facts_.table.ours()) facts_.host.equip(*ours);
  return true;
}

void Negotiation::local_added(const Endpoint& endpoint, const TypeSupport& type) {
  Endpoint equipped = endpoint;
  facts_.host.equip(equipped);
  facts_.erase(endpoint.id);  // an endpoint of another process may have used the same id
  facts_.table.add_ours(equipped, type);
}

void Negotiation::local_removed(EndpointId id) { facts_.erase(id); }

/// Announcements of another process with the id of one of our endpoints are ignored.
bool Negotiation::endpoint_seen(const Endpoint& endpoint) {
  const TableEntry* const known = facts_.table.find(endpoint.id);
  if (known != nullptr && known->is_ours()) return false;
  facts_.table.enter(endpoint);
  facts_.history.begins_anew(endpoint);
  return facts_.table.is_topic_of_ours(endpoint.topic);
}

bool Negotiation::endpoint_departed(EndpointId id) {
  const TableEntry* const entry = facts_.table.find(id);
  if (entry == nullptr || entry->is_ours()) return false;
  const bool concerns_ours = is_of_our_topic(facts_.table, id);
  facts_.erase(id);
  return concerns_ours;
}

bool Negotiation::endpoint_lost(EndpointId id, Time now) {
  return facts_.table.lost(id, now) && is_of_our_topic(facts_.table, id);
}

/// Requests of readers that are lost or not in the table are ignored: when such a reader is announced
/// again, the announcement contains its request in force.
bool Negotiation::request_received(const Request& request) {
  TableEntry* const reader = facts_.table.find(request.reader);
  if (reader == nullptr || reader->is_ours() || reader->lost()) return false;
  reader->endpoint.request = request;
  facts_.history.begins_anew(reader->endpoint);
  return facts_.table.is_topic_of_ours(reader->endpoint.topic);
}

bool Negotiation::requirement_changed(EndpointId reader, const Selection& selection) {
  TableEntry* const ours = facts_.table.find_ours(reader);
  if (ours == nullptr) return false;
  Request& request = ours->endpoint.request;
  std::vector<std::uint64_t> words = selection.mask().to_words();
  std::vector<std::byte> parts;
  if (!selection.is_mask()) parts = selection.to_bytes();
  if (words == request.mask_words && parts == request.parts) return false;
  request.mask_words = std::move(words);
  request.parts = std::move(parts);
  return renew(request);
}

bool Negotiation::rate_changed(EndpointId reader, std::uint32_t min_period_us) {
  TableEntry* const ours = facts_.table.find_ours(reader);
  if (ours == nullptr || ours->endpoint.request.min_period_us == min_period_us) return false;
  ours->endpoint.request.min_period_us = min_period_us;
  return renew(ours->endpoint.request);
}

/// If the path by which retained samples came is lost, all retained samples are sent again.
bool Negotiation::connection_changed(EndpointId reader, EndpointId writer, TransportKind path,
                                     bool connected) {
  TableEntry* const ours = facts_.table.find_ours(reader);
  if (ours == nullptr) return false;
  Request& request = ours->endpoint.request;
  std::vector<EndpointId>& writers = path == TransportKind::shm ? request.attached : request.listening;
  if (connected == holds(writers, writer)) return false;
  renew(request);
  if (connected) {
    writers.push_back(writer);
    return true;
  }
  std::erase(writers, writer);
  if (!holds(request.listening, writer)) std::erase(request.begun, writer);
  facts_.history.disconnected(ours->endpoint, writer);
  return true;
}

bool Negotiation::history_began(EndpointId reader, EndpointId writer) {
  TableEntry* const ours = facts_.table.find_ours(reader);
  if (ours == nullptr || holds(ours->endpoint.request.begun, writer)) return false;
  ours->endpoint.request.begun.push_back(writer);
  return renew(ours->endpoint.request);
}

bool Negotiation::history_came(EndpointId reader, EndpointId writer) {
  return facts_.table.find_ours(reader) != nullptr && facts_.history.came(reader, writer);
}

bool Negotiation::history_given(EndpointId writer, EndpointId reader) {
  const Endpoint* const to = facts_.table.known(reader);
  return to != nullptr && facts_.table.find_ours(writer) != nullptr && facts_.history.given(writer, *to);
}

bool Negotiation::reach_changed(EndpointId writer, EndpointId reader, const std::string& why_not) {
  return facts_.table.find_ours(writer) != nullptr && facts_.unreachable.changed({writer, reader}, why_not);
}

bool Negotiation::tick(Time now) {
  comparisons_.refill();
  const std::vector<EndpointId> forgotten = facts_.table.lost_for(forget_lost_after, now);
  for (const EndpointId id : forgotten) facts_.erase(id);
  return !forgotten.empty();
}

Serving Negotiation::serving(EndpointId writer) const {
  const TableEntry* const ours = facts_.table.find_ours(writer);
  return ours == nullptr ? Serving{} : serving_of(*ours, facts_, comparisons_);
}

std::vector<Hearing> Negotiation::hearing(EndpointId reader) const {
  const TableEntry* const ours = facts_.table.find_ours(reader);
  return ours == nullptr ? std::vector<Hearing>{} : hearing_of(*ours, facts_, comparisons_);
}

const Endpoint* Negotiation::local(EndpointId id) const {
  const TableEntry* const ours = facts_.table.find_ours(id);
  return ours == nullptr ? nullptr : &ours->endpoint;
}

}  // namespace sft::core
