// The desired states of our writers and readers, as they follow from the known facts.
#include <algorithm>
#include <string>
#include <utility>
#include <vector>

#include "core/negotiation/negotiation.h"
#include "core/negotiation/pair.h"
#include "core/negotiation/requested_selection.h"

namespace sft::core {

namespace {

void note_mismatch(const Verdict& verdict, PublisherStatus::Reader& status) {
  status.reason = verdict.mismatch;
  status.mismatch = verdict.definitions;
  status.incompatible_type = verdict.incompatible_type;
  status.incompatible_policy = verdict.incompatible_policy;
}

/// Returns the selection that the reader requests. It is decoded again only if the request has changed.
const Result<Selection>& asked_of(const TableEntry& reader, const TypeSupport& type) {
  const Request& request = reader.endpoint.request;
  TableEntry::Decoded& last = reader.decoded;
  if (last.type != &type || last.mask_words != request.mask_words || last.parts != request.parts)
    last = {&type, request.mask_words, request.parts, requested_selection(request, type)};
  return last.selection;
}

/// The facts about one pair from which its route follows.
struct PairFacts {
  const Verdict& verdict;
  std::uint32_t owed = 0;  ///< the number of retained samples that the reader has to get first
  const std::string* unreached = nullptr;  ///< why the reader cannot be woken in shared memory; null: it can
  const LocalHost& host;
};

void serve(const TableEntry& writer, const TableEntry& reader, const PairFacts& facts, Serving& serving) {
  const auto& [verdict, owed, unreached, host] = facts;
  const Endpoint& r = reader.endpoint;
  PublisherStatus::Reader& status = serving.readers.emplace_back();
  status.id = r.id;
  status.node = r.node;
  status.request_sequence = r.request.sequence;
  if (!verdict.mismatch.empty()) return note_mismatch(verdict, status);
  const Result<Selection>& asked = asked_of(reader, *writer.type);
  if (!asked) {
    status.reason = "it asks for parts or conditions that do not fit the type: " + asked.error().message;
    return;
  }
  status.mask = asked->mask();
  status.selection = *asked;
  const std::uint32_t period = r.request.min_period_us;
  status.max_rate_hz = period == 0 ? 0 : 1e6 / period;
  if (reader.lost()) {
    status.reason = "its node does not answer";
    return;
  }
  serving.memory_port |= verdict.memory;
  const bool history_first = owed != 0 && verdict.network;
  const bool reliable = r.qos.reliability == Reliability::reliable;
  const bool listens = verdict.network && holds(r.request.listening, writer.endpoint.id);
  serving.history_owed |= history_first;
  const bool attached = verdict.memory && !history_first && holds(r.request.attached, writer.endpoint.id);
  const bool unreachable = attached && unreached != nullptr;
  if (unreachable) serving.unreached.push_back({r.id, r.doorbell, *asked, period});
  if (attached && !unreachable) {
    status.served = true;
    status.transport = TransportKind::shm;
    status.reason = "same host";
    const bool begun = holds(r.request.begun, writer.endpoint.id);
    serving.memory.push_back({r.id, r.doorbell, *asked, period, nullptr, begun ? 0 : owed, false, reliable});
    if (listens)
      serving.fallback.push_back({r.id, host.address_of(r), *asked, period, nullptr, 0, true, reliable});
  } else if (listens) {
    status.served = true;
    status.transport = TransportKind::udp;
    status.reason = !verdict.memory ? verdict.network_reason
                    : unreachable   ? *unreached
                    : history_first ? "same host; retained samples come first, by UDP"
                                    : "same host, shared memory is being attached";
    serving.network.push_back({r.id, host.address_of(r), *asked, period, nullptr, owed, false, reliable});
  } else if (verdict.network) {
    status.reason = unreachable ? *unreached : "the subscriber is not listening yet";
  } else {
    status.no_path = !verdict.memory || unreachable;
    status.no_path_yet = verdict.memory_may_come || unreachable;
    status.reason = unreachable      ? "UDP is ruled out, and " + *unreached
                    : verdict.memory ? "shared memory is being attached"
                                     : "UDP is ruled out, and " + verdict.network_reason;
  }
}

/// Notes in `serving` whether this reader needs assertions of liveliness. All matching readers count, even
/// those that are not served at present.
void look_after_lease(const Endpoint& reader, const PublisherStatus::Reader& status, Serving& serving) {
  const bool matches = !status.incompatible_type && status.incompatible_policy == QosPolicy::none;
  if (!matches || reader.qos.liveliness_lease.count() == 0) return;
  serving.lease_requested = true;
  const bool is_sent_all = reader.request.min_period_us == 0 && status.selection.gate().is_open();
  serving.samples_assert &= status.served && is_sent_all;
}

Hearing hear(const TableEntry& writer, const Endpoint& r, const Verdict& verdict, const HistoryState& history,
             std::uint64_t network) {
  const Endpoint& w = writer.endpoint;
  const std::uint32_t owed = history.owed(w, r);
  const bool history_first = owed != 0 && verdict.network;
  // Without this, new samples in shared memory would overtake the retained samples.
  const bool history_comes = history_first && !history.has_come(r.id, w.id);
  const bool awaited = history_first || (owed != 0 && !holds(r.request.begun, w.id));
  const bool reliable = r.qos.reliability == Reliability::reliable;
  const bool attached = holds(r.request.attached, w.id);
  const Announced node{true, w.addresses, w.network == network};
  return {.source = {w.id, w.max_sample_bytes, awaited, reliable, w.waits, node, !writer.lost()},
          .offered = w.qos,
          .owed = owed,
          .memory = verdict.memory && !history_comes && (!writer.lost() || attached),
          .network = verdict.network,
          .status = heard_as(w, !writer.lost(), r, verdict, history_comes)};
}

/// Limits the writers to the maximum number that a request can list. Writers whose nodes answer are
/// preferred, and among these the writers that have been known for the longest time.
void hear_no_more_than_possible(std::vector<Hearing>& hearing, const EndpointTable& table) {
  std::vector<Hearing*> matched;
  for (Hearing& h : hearing) {
    if (h.memory || h.network) matched.push_back(&h);
  }
  if (matched.size() <= writers_per_reader_max) return;
  std::ranges::sort(matched, {}, [&](const Hearing* h) {
    const TableEntry& entry = *table.find(h->source.writer);
    return std::pair(entry.lost(), entry.arrival);
  });
  for (std::size_t i = writers_per_reader_max; i < matched.size(); ++i) {
    Hearing& h = *matched[i];
    h.memory = h.network = h.status.matched = h.status.connected = false;
    h.status.reason =
        "the subscriber hears as many publishers as one can, " + std::to_string(writers_per_reader_max);
  }
}

}  // namespace

Serving Negotiation::serving(EndpointId id, const Unreachable& unreachable) const {
  Serving serving;
  const TableEntry* const writer = table_.find_ours(id);
  if (writer == nullptr) return serving;
  const std::vector<const TableEntry*> readers = table_.counterparts(*writer);
  serving.readers.reserve(readers.size());
  for (const TableEntry* reader : readers) {
    const Verdict verdict =
        evaluate({writer->endpoint, reader->endpoint, true}, *writer->type, host_.self(), &comparisons_);
    const auto unreached = unreachable.find(reader->endpoint.id);
    serve(*writer, *reader,
          {.verdict = verdict,
           .owed = history_.owed(writer->endpoint, reader->endpoint),
           .unreached = unreached == unreachable.end() ? nullptr : &unreached->second,
           .host = host_},
          serving);
    look_after_lease(reader->endpoint, serving.readers.back(), serving);
  }
  return serving;
}

std::vector<Hearing> Negotiation::hearing(EndpointId id) const {
  std::vector<Hearing> result;
  const TableEntry* const reader = table_.find_ours(id);
  if (reader == nullptr) return result;
  for (const TableEntry* writer : table_.counterparts(*reader)) {
    const bool we_write = writer->is_ours();
    const Verdict verdict = evaluate({writer->endpoint, reader->endpoint, we_write},
                                     we_write ? *writer->type : *reader->type, host_.self(), &comparisons_);
    result.push_back(hear(*writer, reader->endpoint, verdict, history_, host_.self().network));
  }
  if (result.size() > writers_per_reader_max) hear_no_more_than_possible(result, table_);
  return result;
}

}  // namespace sft::core
