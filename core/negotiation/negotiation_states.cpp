// This file derives the desired states from the table: whom each of our writers serves, and whom each of our
// readers hears.
#include <algorithm>
#include <utility>

#include "core/negotiation/address_choice.h"
#include "core/negotiation/negotiation.h"

namespace sft::core {

namespace {
bool holds(const std::vector<EndpointId>& writers, EndpointId id) {
  return std::find(writers.begin(), writers.end(), id) != writers.end();
}
}  // namespace

/// Retained samples that the reader is still to get.
std::uint32_t Negotiation::history_owed(const Entry& writer, const Endpoint& reader) {
  const Qos& offered = writer.endpoint.qos;
  const bool durable = offered.durability == Durability::transient_local &&
                       reader.qos.durability == Durability::transient_local;
  if (!durable || writer.history_given.contains(reader.id)) return 0;
  return std::min(offered.history_depth, reader.qos.history_depth);
}

/// `definitions`: of the type of one of ours, others than ours that were met so far.
Verdict Negotiation::judge(const Entry& writer, const Entry& reader, int& definitions) const {
  const bool we_write = writer.type != nullptr;
  const TypeSupport& type = we_write ? *writer.type : *reader.type;
  const bool differs = writer.endpoint.type_hash != reader.endpoint.type_hash;
  const bool is_compared = !differs || ++definitions <= TypeComparisons::compared_at_once;
  return core::judge({writer.endpoint, reader.endpoint, we_write}, type, self_,
                     is_compared ? &comparisons_ : nullptr);
}

std::vector<const Negotiation::Entry*> Negotiation::others(const Entry& entry) const {
  std::vector<const Entry*> found;
  for (const EndpointId id : topics_.at(entry.endpoint.topic)) {
    const Entry& other = entries_.at(id);
    if (other.endpoint.role != entry.endpoint.role) found.push_back(&other);
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

ReaderStatus Negotiation::serve(const Entry& writer, const Entry& reader, const Verdict& verdict,
                                Serving& serving) const {
  const Endpoint& r = reader.endpoint;
  const TypeSupport& type = *writer.type;
  ReaderStatus status{.id = r.id, .node = r.node, .request_sequence = r.request.sequence};
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
  serving.memory_port |= verdict.memory;
  const std::uint32_t owed = history_owed(writer, r);
  const bool history_first = owed != 0 && verdict.network;
  const bool reliable = r.qos.reliability == Reliability::reliable;
  const bool listens = verdict.network && holds(r.request.listening, writer.endpoint.id);
  serving.history_owed |= history_first;
  const bool attached = verdict.memory && !history_first && holds(r.request.attached, writer.endpoint.id);
  const auto unreached = writer.unreached.find(r.id);
  const bool unreachable = attached && unreached != writer.unreached.end();
  if (unreachable) serving.unreached.push_back({r.id, r.doorbell, status.mask, period});
  if (attached && !unreachable) {
    status.served = true;
    status.transport = TransportKind::shm;
    status.reason = "same host";
    const bool begun = holds(r.request.begun, writer.endpoint.id);
    serving.memory.push_back(
        {r.id, r.doorbell, status.mask, period, nullptr, begun ? 0 : owed, false, reliable});
    if (listens)
      serving.fallback.push_back({r.id, address_of(r), status.mask, period, nullptr, 0, true, reliable});
  } else if (listens) {
    status.served = true;
    status.transport = TransportKind::udp;
    status.reason = !verdict.memory ? verdict.network_reason
                    : unreachable   ? unreached->second
                    : history_first ? "same host, what was published before comes first"
                                    : "same host, shared memory is being attached";
    serving.network.push_back({r.id, address_of(r), status.mask, period, nullptr, owed, false, reliable});
  } else if (verdict.network) {
    status.reason = unreachable ? unreached->second : "the subscriber is not listening yet";
  } else {
    status.no_path = !verdict.memory || unreachable;
    status.no_path_yet = verdict.memory_may_come || unreachable;
    status.reason = unreachable      ? "UDP is ruled out, and " + unreached->second
                    : verdict.memory ? "shared memory is being attached"
                                     : "UDP is ruled out, and " + verdict.network_reason;
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
  int definitions = 0;
  for (const Entry* reader : others(entry->second)) {
    const Verdict verdict = judge(entry->second, *reader, definitions);
    serving.readers.push_back(serve(entry->second, *reader, verdict, serving));
    look_after_lease(reader->endpoint, serving.readers.back(), serving);
  }
  return serving;
}

std::vector<Hearing> Negotiation::hearing(EndpointId reader) const {
  std::vector<Hearing> result;
  const auto entry = entries_.find(reader);
  if (entry == entries_.end() || entry->second.type == nullptr) return result;
  const Endpoint& r = entry->second.endpoint;
  int definitions = 0;
  for (const Entry* writer : others(entry->second)) {
    const Endpoint& w = writer->endpoint;
    const Verdict verdict = judge(*writer, entry->second, definitions);
    const std::uint32_t owed = history_owed(*writer, r);
    const bool history_first = owed != 0 && verdict.network;
    // Samples that others get through shared memory would overtake the retained ones.
    const bool history_comes = history_first && !entry->second.history_came.contains(w.id);
    const bool awaited = history_first || (owed != 0 && !holds(r.request.begun, w.id));
    const bool reliable = r.qos.reliability == Reliability::reliable;
    const bool attached = holds(r.request.attached, w.id);
    const Announced node{true, w.addresses, w.network == self_.network};
    result.push_back({.source = {w.id, w.max_sample_bytes, awaited, reliable, w.waits, node, !writer->lost()},
                      .offered = w.qos,
                      .owed = owed,
                      .memory = verdict.memory && !history_comes && (!writer->lost() || attached),
                      .network = verdict.network,
                      .status = heard_as(w, !writer->lost(), r, verdict, history_comes)});
  }
  if (result.size() > writers_per_reader_max) hear_no_more_than_possible(result);
  return result;
}

/// A request has no room for more: those that answer come first, and of these the ones that are known
/// longest.
void Negotiation::hear_no_more_than_possible(std::vector<Hearing>& hearing) const {
  std::vector<Hearing*> matched;
  for (Hearing& h : hearing) {
    if (h.memory || h.network) matched.push_back(&h);
  }
  if (matched.size() <= writers_per_reader_max) return;
  std::ranges::sort(matched, {}, [&](const Hearing* h) {
    const Entry& entry = entries_.at(h->source.writer);
    return std::pair(entry.lost(), entry.arrival);
  });
  for (std::size_t i = writers_per_reader_max; i < matched.size(); ++i) {
    Hearing& h = *matched[i];
    h.memory = h.network = h.status.matched = h.status.connected = false;
    h.status.reason =
        "the subscriber hears as many publishers as one can, " + std::to_string(writers_per_reader_max);
  }
}

std::vector<const Endpoint*> Negotiation::present() const {
  std::vector<const Endpoint*> endpoints;
  for (const auto& [id, entry] : entries_) {
    if (!entry.lost()) endpoints.push_back(&entry.endpoint);
  }
  return endpoints;
}

void Negotiation::progressed(NodeId node, const Progress& progress) {
  const auto entry = entries_.find(progress.writer);
  if (entry == entries_.end() || entry->second.endpoint.node_id != node) return;
  if (entry->second.endpoint.role == Role::writer) entry->second.progress = progress;
}

const Progress* Negotiation::progress_of(EndpointId id) const {
  const auto entry = entries_.find(id);
  return entry == entries_.end() || !entry->second.progress ? nullptr : &*entry->second.progress;
}

}  // namespace sft::core
