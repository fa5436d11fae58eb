#include "core/negotiation/negotiation.h"

#include <algorithm>
#include <utility>

namespace sft::core {

namespace {
bool holds(const std::vector<EndpointId>& writers, EndpointId id) {
  return std::find(writers.begin(), writers.end(), id) != writers.end();
}

/// Returns true if others may take, or have already taken, what was said in our reader's name for its
/// request.
bool outbids(const Request& said, const Request& ours) {
  Request copy = said;
  copy.announcer = ours.announcer;
  return said.sequence > ours.sequence || (said.sequence == ours.sequence && copy != ours);
}
}  // namespace

Negotiation::Negotiation(const Limits& limits)
    : limits_(limits),
      shares_(
          {.entries = limits.endpoints, .of_announcer = limits.of_announcer, .of_topic = limits.of_topic}),
      early_requests_(limits.endpoints) {}

/// Returns the token of the shared memory that our endpoint can use. A writer that may not write to that
/// memory has none, so that nobody waits for it there.
HostToken Negotiation::host_of(Role role) const {
  return role == Role::writer && !self_.may_write_memory ? HostToken{} : self_.host;
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
  erase(endpoint.id);  // somebody else may have used the id
  entries_.insert_or_assign(endpoint.id, std::move(entry));
  entries_.at(endpoint.id).arrival = ++arrivals_;
  index(endpoint);
}

void Negotiation::local_removed(EndpointId id) { erase(id); }

void Negotiation::index(const Endpoint& endpoint) { topics_[endpoint.topic].insert(endpoint.id); }

void Negotiation::unindex(const Endpoint& endpoint) {
  const auto topic = topics_.find(endpoint.topic);
  topic->second.erase(endpoint.id);
  if (topic->second.empty()) topics_.erase(topic);
}

/// A reader that comes back after this is owed the history again.
void Negotiation::erase(EndpointId id) {
  const auto gone = entries_.find(id);
  if (gone == entries_.end()) return;
  unindex(gone->second.endpoint);
  entries_.erase(gone);
  shares_.remove(id);
  for (auto& [other, entry] : entries_) {
    entry.history_given.erase(id);
    entry.unreached.erase(id);
  }
}

bool Negotiation::endpoint_seen(const Endpoint& endpoint) {
  const auto known = entries_.find(endpoint.id);
  const bool is_known = known != entries_.end();
  if (is_known && known->second.type != nullptr) {
    hear_of_our_own(known->second, endpoint);
    return false;
  }
  if (is_known && is_outdated(known->second, endpoint)) return false;
  if (!is_known && !admit(endpoint)) return false;
  if (is_known) unindex(known->second.endpoint);
  Entry& entry = entries_[endpoint.id];
  if (!is_known) entry.arrival = ++arrivals_;
  const Endpoint known_endpoint = std::exchange(entry.endpoint, endpoint);
  entry.endpoint.request.announcer = endpoint.announcer;
  index(endpoint);
  const AnnouncerId* const entered_by = shares_.announcer_of(endpoint.id);
  if (entered_by == nullptr || *entered_by != endpoint.announcer)
    shares_.enter(endpoint.id, endpoint.announcer, endpoint.topic);
  // A request that another node made in the reader's name is not the reader's request.
  if (is_known && known_endpoint.node_id == endpoint.node_id) adopt(entry, known_endpoint.request);
  entry.lost_since.reset();
  entry.silent = false;
  adopt_early_request(entry);
  owe_what_has_not_begun(entry.endpoint);
  return true;
}

/// Returns true if there is room for a newcomer. Another endpoint may have to leave to make the room.
bool Negotiation::admit(const Endpoint& endpoint) {
  const TableShares::Admission admission = shares_.admit(endpoint.announcer, endpoint.topic);
  if (!admission.granted) {
    ++ignored_;
    ++refusals_[endpoint.node];
  } else if (admission.instead_of) {
    ++ignored_;
    ++refusals_[entries_.at(*admission.instead_of).endpoint.node];
    erase(*admission.instead_of);
  }
  return admission.granted;
}

/// Returns true if this is an earlier announcement of the same announcer, which has come late. Discovery
/// decides which of several announcers is believed.
bool Negotiation::is_outdated(const Entry& entry, const Endpoint& endpoint) {
  const Endpoint& known = entry.endpoint;
  return !entry.lost() && endpoint.announcer == known.announcer && endpoint.revision < known.revision;
}

/// Somebody else announces an endpoint of ours. A copy of what we said costs nothing.
void Negotiation::hear_of_our_own(Entry& own, const Endpoint& said) {
  Endpoint copy = said;
  copy.request = own.endpoint.request;
  copy.revision = own.endpoint.revision;
  copy.announcer = own.endpoint.announcer;
  const bool is_copy = copy == own.endpoint && said.revision == own.endpoint.revision;
  const bool is_old = said.revision < own.endpoint.revision;
  const bool asks_for_more = outbids(said.request, own.endpoint.request);
  if ((is_copy || is_old) && !asks_for_more) return;
  if (said.revision - own.endpoint.revision <= jump_max) own.endpoint.revision = said.revision;
  contest(own, said.request, "is announced by somebody else, who calls the node '" + said.node + "'");
}

/// The endpoint is to be announced anew, with a request that is later than everything that was said in its
/// name.
void Negotiation::contest(Entry& own, const Request& said, std::string how) {
  Request& ours = own.endpoint.request;
  if (own.endpoint.role == Role::reader) {
    const bool reachable = said.sequence > ours.sequence && said.sequence - ours.sequence <= jump_max;
    ours.sequence = (reachable ? said.sequence : ours.sequence) + 1;
  }
  contested_.push_back({own.endpoint.id, std::move(how)});
}

void Negotiation::adopt_early_request(Entry& entry) {
  const Endpoint& reader = entry.endpoint;
  for (const Request& early : early_requests_.take(reader.id, reader.announcer)) adopt(entry, early);
}

bool Negotiation::endpoint_departed(EndpointId id) {
  early_requests_.forget(id);
  const auto entry = entries_.find(id);
  if (entry == entries_.end()) return false;
  if (entry->second.type != nullptr) {
    contest(entry->second, {}, "was withdrawn by somebody else");
    return false;
  }
  erase(id);
  return true;
}

bool Negotiation::endpoint_lost(EndpointId id, Time now) {
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
  if (entry != entries_.end() && entry->second.type != nullptr) {
    if (outbids(request, entry->second.endpoint.request))
      contest(entry->second, request, "is asked for something by somebody else");
    return false;
  }
  // A lost reader may be forgotten before it is seen again, but its request does not come again.
  if (entry == entries_.end() || entry->second.lost()) {
    ignored_ += early_requests_.keep(request) ? 1 : 0;
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

/// Reordered or repeated ones are not; nor is what the reader's node cannot have sent, since nobody asks for
/// something else so often.
bool Negotiation::adopt(Entry& entry, const Request& request) {
  const Request& known = entry.endpoint.request;
  if (request.sequence <= known.sequence || request.sequence > request_sequence_max) return false;
  const bool is_jump = request.sequence - known.sequence > jump_max;
  if (is_jump && request.announcer != entry.endpoint.announcer) return false;
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

bool Negotiation::tick(Time now) {
  comparisons_.refill();
  std::vector<EndpointId> forgotten;
  for (const auto& [id, entry] : entries_) {
    if (entry.lost_since && now - *entry.lost_since >= limits_.forget_lost_after) forgotten.push_back(id);
  }
  for (const EndpointId id : forgotten) erase(id);
  return !forgotten.empty();
}

const Endpoint* Negotiation::local(EndpointId id) const {
  const auto entry = entries_.find(id);
  return entry == entries_.end() || entry->second.type == nullptr ? nullptr : &entry->second.endpoint;
}

const Endpoint* Negotiation::next_announcement(EndpointId id) {
  const auto entry = entries_.find(id);
  if (entry == entries_.end() || entry->second.type == nullptr) return nullptr;
  ++entry->second.endpoint.revision;
  return &entry->second.endpoint;
}

}  // namespace sft::core
