#include "core/negotiation/negotiation.h"

#include <optional>
#include <utility>

namespace sft::core {

namespace {

/// Gives a changed request of ours a greater sequence.
bool renew(Request& request) {
  ++request.sequence;
  return true;
}

/// Adds the id to the list, or removes it. Returns true if the list contained it before.
bool set(std::vector<EndpointId>& ids, EndpointId id, bool is_in) {
  const bool was_in = holds(ids, id);
  if (is_in && !was_in) ids.push_back(id);
  if (!is_in && was_in) std::erase(ids, id);
  return was_in;
}

}  // namespace

bool Negotiation::self_changed(const Self& self) {
  const bool new_host = self.host != host_.self().host;
  if (!host_.self_changed(self)) return false;
  for (Endpoint* const ours : table_.ours()) {
    host_.equip(*ours);
    if (!new_host || ours->request.attached.empty()) continue;
    ours->request.attached.clear();
    renew(ours->request);
  }
  return true;
}

bool Negotiation::network_changed(const std::vector<UdpAddress>& addresses, const std::vector<Link>& links) {
  host_.network_changed(addresses, links);
  for (Endpoint* const ours : table_.ours()) host_.equip(*ours);
  return true;
}

void Negotiation::local_added(const Endpoint& endpoint, const TypeSupport& type) {
  Endpoint equipped = endpoint;
  host_.equip(equipped);
  erase(endpoint.id);  // an endpoint of another process may have used the same id
  table_.add_ours(equipped, type);
}

void Negotiation::local_removed(EndpointId id) { erase(id); }

/// Announcements of another process with the id of one of our endpoints are ignored.
bool Negotiation::endpoint_seen(const Endpoint& endpoint) {
  const TableEntry* const known = table_.find(endpoint.id);
  if (known != nullptr && known->is_ours()) return false;
  table_.enter(endpoint);
  history_.begins_anew(endpoint);
  return table_.is_topic_of_ours(endpoint.topic);
}

bool Negotiation::endpoint_departed(EndpointId id) {
  const TableEntry* const entry = table_.find(id);
  if (entry == nullptr || entry->is_ours()) return false;
  const bool concerns_ours = table_.is_topic_of_ours(entry->endpoint.topic);
  erase(id);
  return concerns_ours;
}

bool Negotiation::endpoint_lost(EndpointId id, Time now) {
  return table_.lost(id, now) && table_.is_topic_of_ours(table_.find(id)->endpoint.topic);
}

/// Requests of readers that are lost or not in the table are ignored: when such a reader is announced
/// again, the announcement contains its request in force.
bool Negotiation::request_received(const Request& request) {
  TableEntry* const reader = table_.find(request.reader);
  if (reader == nullptr || reader->is_ours() || reader->lost()) return false;
  reader->endpoint.request = request;
  history_.begins_anew(reader->endpoint);
  return table_.is_topic_of_ours(reader->endpoint.topic);
}

bool Negotiation::requirement_changed(EndpointId reader, const Wanted& wanted) {
  TableEntry* const ours = table_.find_ours(reader);
  if (ours == nullptr) return false;
  Request& request = ours->endpoint.request;
  const Request before = request;
  request.mask_words = wanted.selection.mask().to_words();
  request.parts = wanted.selection.is_mask() ? std::vector<std::byte>() : wanted.selection.to_bytes();
  request.min_period_us = wanted.min_period_us;
  return request != before && renew(request);
}

/// If the path by which retained samples came is lost, all retained samples are sent again.
bool Negotiation::connection_changed(EndpointId reader, EndpointId writer, bool listening, bool attached) {
  TableEntry* const ours = table_.find_ours(reader);
  if (ours == nullptr) return false;
  Request& request = ours->endpoint.request;
  const bool listened = set(request.listening, writer, listening);
  const bool was_attached = set(request.attached, writer, attached);
  if (listened == listening && was_attached == attached) return false;
  renew(request);
  if ((listening || !listened) && (attached || !was_attached)) return true;
  if (!listening) std::erase(request.begun, writer);
  history_.disconnected(ours->endpoint, writer);
  return true;
}

bool Negotiation::history_began(EndpointId reader, EndpointId writer) {
  TableEntry* const ours = table_.find_ours(reader);
  if (ours == nullptr || holds(ours->endpoint.request.begun, writer)) return false;
  ours->endpoint.request.begun.push_back(writer);
  return renew(ours->endpoint.request);
}

bool Negotiation::history_came(EndpointId reader, EndpointId writer) {
  return table_.find_ours(reader) != nullptr && history_.came(reader, writer);
}

bool Negotiation::history_given(EndpointId writer, EndpointId reader) {
  const TableEntry* const to = table_.find(reader);
  return to != nullptr && table_.find_ours(writer) != nullptr && history_.given(writer, to->endpoint);
}

bool Negotiation::tick(Time now) {
  comparisons_.refill();
  const std::vector<EndpointId> forgotten = table_.lost_for(forget_lost_after, now);
  for (const EndpointId id : forgotten) erase(id);
  return !forgotten.empty();
}

/// Removes an endpoint. If the endpoint comes back later, it must get the history again.
void Negotiation::erase(EndpointId id) {
  if (table_.erase(id)) history_.forget(id);
}

const Endpoint* Negotiation::local(EndpointId id) const {
  const TableEntry* const ours = table_.find_ours(id);
  return ours == nullptr ? nullptr : &ours->endpoint;
}

}  // namespace sft::core
