#include "core/negotiation.h"

#include <algorithm>
#include <utility>

#include "core/address_choice.h"

namespace sft::core {

namespace {
bool holds(const std::vector<EndpointId>& writers, EndpointId id) {
  return std::find(writers.begin(), writers.end(), id) != writers.end();
}
}  // namespace

/// Of our endpoints: a writer that may not write to that memory has none, so that nobody waits for it there.
HostToken Negotiation::host_of(Role role) const {
  return role == Role::writer && !self_.may_write_shm ? HostToken{} : self_.host;
}

bool Negotiation::self_changed(const Self& self) {
  if (self == self_) return false;
  const bool new_host = self.host != self_.host;
  self_ = self;
  for (auto& [id, entry] : entries_) {
    if (entry.type == nullptr) continue;
    entry.endpoint.host = host_of(entry.endpoint.role);
    entry.endpoint.network = self.network;
    // Attachments were to ports of the memory that is gone.
    if (new_host && !entry.endpoint.request.attached.empty()) {
      entry.endpoint.request.attached.clear();
      ++entry.endpoint.request.sequence;
    }
  }
  return true;
}

bool Negotiation::network_changed(const std::vector<UdpAddress>& addresses, const std::vector<Link>& links) {
  addresses_ = addresses;
  links_ = links;
  for (auto& [id, entry] : entries_) {
    if (entry.type != nullptr && entry.endpoint.may_use_udp) entry.endpoint.addresses = addresses;
  }
  return true;
}

void Negotiation::local_added(const Endpoint& endpoint, const TypeSupport& type) {
  Entry entry{.endpoint = endpoint, .type = &type, .lost_since = {}, .silent = false, .history_given = {}};
  entry.endpoint.host = host_of(endpoint.role);
  entry.endpoint.network = self_.network;
  if (endpoint.may_use_udp && addresses_) entry.endpoint.addresses = *addresses_;
  entries_.insert_or_assign(endpoint.id, std::move(entry));
}

void Negotiation::local_removed(EndpointId id) { erase(id); }

/// A reader that comes back after this is owed the history again.
void Negotiation::erase(EndpointId id) {
  entries_.erase(id);
  for (auto& [other, entry] : entries_) {
    entry.history_given.erase(id);
    entry.unreached.erase(id);
  }
}

bool Negotiation::endpoint_seen(const Endpoint& endpoint) {
  const auto known = entries_.find(endpoint.id);
  if (known != entries_.end() && known->second.type != nullptr) return false;  // an echo of our own
  if (known == entries_.end() && entries_.size() >= limits_.endpoints) {
    ++ignored_;
    return false;
  }
  Entry& entry = entries_[endpoint.id];
  const Request known_request = std::exchange(entry.endpoint, endpoint).request;
  adopt(entry, known_request);
  entry.lost_since.reset();
  entry.silent = false;
  adopt_early_request(entry);
  owe_what_has_not_begun(entry.endpoint);
  return true;
}

void Negotiation::adopt_early_request(Entry& entry) {
  if (const auto early = early_requests_.extract(entry.endpoint.id)) adopt(entry, early.mapped().request);
}

bool Negotiation::endpoint_departed(EndpointId id) {
  early_requests_.erase(id);
  const auto entry = entries_.find(id);
  if (entry == entries_.end() || entry->second.type != nullptr) return false;
  erase(id);
  return true;
}

bool Negotiation::endpoint_lost(EndpointId id, Now now) {
  const auto entry = entries_.find(id);
  if (entry == entries_.end() || entry->second.type != nullptr || entry->second.lost_since) return false;
  entry->second.lost_since = now;
  return true;
}

bool Negotiation::node_lost(NodeId id) {
  bool changed = false;
  for (auto& [endpoint, entry] : entries_) {
    if (entry.endpoint.node_id != id || entry.type != nullptr || entry.silent) continue;
    entry.silent = true;
    changed = true;
  }
  return changed;
}

bool Negotiation::node_returned(NodeId id) {
  bool changed = false;
  for (auto& [endpoint, entry] : entries_) {
    if (entry.endpoint.node_id != id || !entry.silent) continue;
    entry.silent = false;
    if (!entry.lost_since) {
      adopt_early_request(entry);
      owe_what_has_not_begun(entry.endpoint);
    }
    changed = true;
  }
  return changed;
}

bool Negotiation::knows(NodeId id) const {
  return std::ranges::any_of(entries_,
                             [&](const auto& entry) { return entry.second.endpoint.node_id == id; });
}

const Endpoint* Negotiation::known(EndpointId id) const {
  const auto entry = entries_.find(id);
  return entry == entries_.end() ? nullptr : &entry->second.endpoint;
}

bool Negotiation::misses_somebody() const {
  return std::ranges::any_of(entries_, [](const auto& entry) { return entry.second.lost(); });
}

bool Negotiation::request_received(const Request& request) {
  const auto entry = entries_.find(request.reader);
  if (entry != entries_.end() && entry->second.type != nullptr) return false;
  // A lost reader may be forgotten before it is seen again, but its request does not come again.
  if (entry == entries_.end() || entry->second.lost()) {
    keep_for_later(request);
    return false;
  }
  if (!adopt(entry->second, request)) return false;
  owe_what_has_not_begun(entry->second.endpoint);
  return true;
}

/// A reader that lost a writer and found it again begins anew, although the writer may not have noticed.
void Negotiation::owe_what_has_not_begun(const Endpoint& reader) {
  if (reader.qos.durability == Durability::volatile_) return;
  for (auto& [id, entry] : entries_) {
    if (!holds(reader.request.begun, id)) entry.history_given.erase(reader.id);
  }
}

void Negotiation::keep_for_later(const Request& request) {
  const bool known = early_requests_.contains(request.reader);
  if (!known && early_requests_.size() >= limits_.endpoints) {
    ++ignored_;  // the one that has waited longest makes room: its reader is the least likely to come
    early_requests_.erase(
        std::min_element(early_requests_.begin(), early_requests_.end(),
                         [](const auto& a, const auto& b) { return a.second.arrival < b.second.arrival; }));
  }
  EarlyRequest& early = early_requests_[request.reader];
  if (request.sequence > early.request.sequence) early = {request, ++early_arrivals_};
}

bool Negotiation::adopt(Entry& entry, const Request& request) {
  if (request.sequence <= entry.endpoint.request.sequence) return false;  // reordered or repeated
  entry.endpoint.request = request;
  return true;
}

bool Negotiation::requirement_changed(EndpointId reader, const FieldMask& mask) {
  const auto entry = entries_.find(reader);
  if (entry == entries_.end() || entry->second.type == nullptr) return false;
  std::vector<std::uint64_t> words = mask.to_words();
  Request& request = entry->second.endpoint.request;
  if (words == request.mask_words) return false;
  request.mask_words = std::move(words);
  ++request.sequence;
  return true;
}

bool Negotiation::rate_changed(EndpointId reader, std::uint32_t min_period_us) {
  const auto entry = entries_.find(reader);
  if (entry == entries_.end() || entry->second.type == nullptr) return false;
  Request& request = entry->second.endpoint.request;
  if (request.min_period_us == min_period_us) return false;
  request.min_period_us = min_period_us;
  ++request.sequence;
  return true;
}

bool Negotiation::connection_changed(EndpointId reader, EndpointId writer, TransportKind path,
                                     bool connected) {
  const auto entry = entries_.find(reader);
  if (entry == entries_.end() || entry->second.type == nullptr) return false;
  Request& request = entry->second.endpoint.request;
  std::vector<EndpointId>& writers = path == TransportKind::shm ? request.attached : request.listening;
  if (connected == holds(writers, writer)) return false;
  if (connected) {
    writers.push_back(writer);
  } else {
    std::erase(writers, writer);
    if (path == TransportKind::udp || !holds(request.listening, writer)) {  // the one that it came by
      std::erase(request.begun, writer);
      entry->second.history_came.erase(writer);
    }
    owe_what_has_not_begun(entry->second.endpoint);
  }
  ++request.sequence;
  return true;
}

bool Negotiation::history_began(EndpointId reader, EndpointId writer) {
  const auto entry = entries_.find(reader);
  if (entry == entries_.end() || entry->second.type == nullptr) return false;
  Request& request = entry->second.endpoint.request;
  if (holds(request.begun, writer)) return false;
  request.begun.push_back(writer);
  ++request.sequence;
  return true;
}

bool Negotiation::history_came(EndpointId reader, EndpointId writer) {
  const auto entry = entries_.find(reader);
  if (entry == entries_.end() || entry->second.type == nullptr) return false;
  return entry->second.history_came.insert(writer).second;
}

bool Negotiation::history_given(EndpointId writer, EndpointId reader) {
  const auto from = entries_.find(writer);
  const auto to = entries_.find(reader);
  if (from == entries_.end() || from->second.type == nullptr || to == entries_.end()) return false;
  if (!holds(to->second.endpoint.request.begun, writer)) return false;
  return from->second.history_given.insert(reader).second;
}

bool Negotiation::reach_changed(EndpointId writer, EndpointId reader, const std::string& why_not) {
  const auto entry = entries_.find(writer);
  if (entry == entries_.end() || entry->second.type == nullptr) return false;
  auto& unreached = entry->second.unreached;
  if (why_not.empty()) return unreached.erase(reader) != 0;
  return std::exchange(unreached[reader], why_not) != why_not;
}

bool Negotiation::tick(Now now) {
  std::vector<EndpointId> forgotten;
  for (const auto& [id, entry] : entries_) {
    if (entry.lost_since && now - *entry.lost_since >= limits_.forget_lost_after) forgotten.push_back(id);
  }
  for (const EndpointId id : forgotten) erase(id);
  return !forgotten.empty();
}

/// Retained samples that the reader is still to get.
std::uint32_t Negotiation::history_owed(const Entry& writer, const Endpoint& reader) {
  const Qos& offered = writer.endpoint.qos;
  const bool durable = offered.durability == Durability::transient_local &&
                       reader.qos.durability == Durability::transient_local;
  if (!durable || writer.history_given.contains(reader.id)) return 0;
  return std::min(offered.history_depth, reader.qos.history_depth);
}

Verdict Negotiation::judge(const Entry& writer, const Entry& reader) const {
  const bool we_write = writer.type != nullptr;
  const TypeSupport& type = we_write ? *writer.type : *reader.type;
  return core::judge({writer.endpoint, reader.endpoint, we_write}, type, self_, comparisons_);
}

std::vector<const Negotiation::Entry*> Negotiation::others(const Entry& entry) const {
  std::vector<const Entry*> found;
  for (const auto& [id, other] : entries_) {
    if (other.endpoint.role != entry.endpoint.role && other.endpoint.topic == entry.endpoint.topic) {
      found.push_back(&other);
    }
  }
  return found;
}

UdpAddress Negotiation::address_of(const Endpoint& reader) const {
  UdpAddress address;
  if (reader.network != self_.network) {
    address = choose_address(reader.addresses, links_);
  } else {  // one network stack: never leaves the machine
    address = reader.addresses.front();
    const bool has_ipv4 = std::ranges::any_of(reader.addresses, [](const auto& a) { return a.ip.is_ipv4(); });
    address.ip = has_ipv4 ? loopback_ipv4 : loopback_ipv6;
  }
  address.node = reader.node_id;
  return address;
}

ReaderStatus Negotiation::serve(const Entry& writer, const Entry& reader, Serving& serving) const {
  const Endpoint& r = reader.endpoint;
  const TypeSupport& type = *writer.type;
  ReaderStatus status{.id = r.id, .node = r.node, .request_sequence = r.request.sequence};
  const Verdict verdict = judge(writer, reader);
  if (!verdict.mismatch.empty()) {
    status.reason = verdict.mismatch;
    status.mismatch = verdict.definitions;
    status.incompatible_type = verdict.incompatible_type;
    status.incompatible_policy = verdict.incompatible_policy;
    return status;
  }
  status.mask = type.closed(FieldMask::from_words(type.leaves(), r.request.mask_words));
  const std::uint32_t period = r.request.min_period_us;
  status.max_rate_hz = period == 0 ? 0 : 1e6 / period;
  if (reader.lost()) {
    status.reason = "its node does not answer";
    return status;
  }
  serving.shm_port |= verdict.shm;
  const std::uint32_t owed = history_owed(writer, r);
  const bool history_first = owed != 0 && verdict.udp;
  const bool reliable = r.qos.reliability == Reliability::reliable;
  const bool listens = verdict.udp && holds(r.request.listening, writer.endpoint.id);
  serving.history_owed |= history_first;
  const bool attached = verdict.shm && !history_first && holds(r.request.attached, writer.endpoint.id);
  const auto unreached = writer.unreached.find(r.id);
  const bool unreachable = attached && unreached != writer.unreached.end();
  if (unreachable) serving.unreached.push_back({r.id, r.doorbell, status.mask, period});
  if (attached && !unreachable) {
    status.served = true;
    status.transport = TransportKind::shm;
    status.reason = "same host";
    const bool begun = holds(r.request.begun, writer.endpoint.id);
    serving.shm.push_back({r.id, r.doorbell, status.mask, period, nullptr, begun ? 0 : owed});
    if (listens)
      serving.spare.push_back({r.id, address_of(r), status.mask, period, nullptr, 0, true, reliable});
  } else if (listens) {
    status.served = true;
    status.transport = TransportKind::udp;
    status.reason = !verdict.shm    ? verdict.udp_reason
                    : unreachable   ? unreached->second
                    : history_first ? "same host, what was published before comes first"
                                    : "same host, shared memory is being attached";
    serving.udp.push_back({r.id, address_of(r), status.mask, period, nullptr, owed, false, reliable});
  } else if (verdict.udp) {
    status.reason = unreachable ? unreached->second : "the subscriber is not listening yet";
  } else {
    status.no_path = !verdict.shm || unreachable;
    status.no_path_yet = verdict.shm_may_come || unreachable;
    status.reason = unreachable   ? "UDP is ruled out, and " + unreached->second
                    : verdict.shm ? "shared memory is being attached"
                                  : "UDP is ruled out, and " + verdict.udp_reason;
  }
  return status;
}

/// Liveliness is the same for all that match, served at present or not.
void Negotiation::look_after_lease(const Endpoint& reader, const ReaderStatus& status, Serving& serving) {
  const bool matches = !status.incompatible_type && status.incompatible_policy == QosPolicy::none;
  if (!matches || reader.qos.liveliness_lease.count() == 0) return;
  serving.lease_requested = true;
  serving.samples_tell &= status.served && reader.request.min_period_us == 0;
}

Serving Negotiation::serving(EndpointId writer) const {
  Serving serving;
  const auto entry = entries_.find(writer);
  if (entry == entries_.end() || entry->second.type == nullptr) return serving;
  for (const Entry* reader : others(entry->second)) {
    serving.readers.push_back(serve(entry->second, *reader, serving));
    look_after_lease(reader->endpoint, serving.readers.back(), serving);
  }
  return serving;
}

WriterStatus Negotiation::status_of(const Entry& writer, const Endpoint& reader, const Verdict& verdict,
                                    bool history_comes) {
  const EndpointId id = writer.endpoint.id;
  const bool attached = verdict.shm && holds(reader.request.attached, id);
  const bool listening = verdict.udp && holds(reader.request.listening, id);
  WriterStatus status{.id = id, .node = writer.endpoint.node, .alive = !writer.lost()};
  status.incompatible_type = verdict.incompatible_type;
  status.incompatible_policy = verdict.incompatible_policy;
  status.matched = verdict.shm || verdict.udp;
  status.connected = !writer.lost() && (attached || listening);
  status.no_path = !status.matched && verdict.mismatch.empty();
  status.no_path_yet = verdict.shm_may_come;
  status.transport = attached || !verdict.udp ? TransportKind::shm : TransportKind::udp;
  status.mismatch = verdict.definitions;
  status.reason = !verdict.mismatch.empty()      ? verdict.mismatch
                  : writer.lost()                ? "its node does not answer"
                  : attached                     ? "same host"
                  : verdict.shm && history_comes ? "same host, what was published before comes first"
                  : verdict.shm                  ? "same host, shared memory is being attached"
                  : verdict.udp                  ? verdict.udp_reason
                                                 : "UDP is ruled out, and " + verdict.udp_reason;
  return status;
}

std::vector<Hearing> Negotiation::hearing(EndpointId reader) const {
  std::vector<Hearing> result;
  const auto entry = entries_.find(reader);
  if (entry == entries_.end() || entry->second.type == nullptr) return result;
  const Endpoint& r = entry->second.endpoint;
  for (const Entry* writer : others(entry->second)) {
    const Endpoint& w = writer->endpoint;
    const Verdict verdict = judge(*writer, entry->second);
    const std::uint32_t owed = history_owed(*writer, r);
    const bool history_first = owed != 0 && verdict.udp;
    // What others get through shared memory would overtake it.
    const bool history_comes = history_first && !entry->second.history_came.contains(w.id);
    const bool awaited = history_first || (owed != 0 && !holds(r.request.begun, w.id));
    const bool reliable = r.qos.reliability == Reliability::reliable;
    const Announced node{true, w.addresses, w.network == self_.network};
    result.push_back({.source = {w.id, w.max_sample_bytes, awaited, reliable, w.waits, node},
                      .offered = w.qos,
                      .owed = owed,
                      .shm = verdict.shm && !history_comes,
                      .udp = verdict.udp,
                      .status = status_of(*writer, r, verdict, history_comes)});
  }
  return result;
}

std::vector<const Endpoint*> Negotiation::present() const {
  std::vector<const Endpoint*> endpoints;
  for (const auto& [id, entry] : entries_) {
    if (!entry.lost()) endpoints.push_back(&entry.endpoint);
  }
  return endpoints;
}

const Endpoint* Negotiation::local(EndpointId id) const {
  const auto entry = entries_.find(id);
  return entry == entries_.end() || entry->second.type == nullptr ? nullptr : &entry->second.endpoint;
}

}  // namespace sft::core
