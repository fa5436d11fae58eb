#include "core/negotiation/hearing.h"

#include <algorithm>
#include <string>
#include <utility>

#include "core/negotiation/id_list.h"
#include "core/negotiation/pair.h"

namespace sft::core {

namespace {

Hearing hear(const TableEntry& writer, const Endpoint& r, const Verdict& verdict, const KnownFacts& facts) {
  const Endpoint& w = writer.endpoint;
  const std::uint32_t owed = facts.history.owed(w, r);
  const bool history_first = owed != 0 && verdict.network;
  // Without this, new samples in shared memory would overtake the retained samples.
  const bool history_comes = history_first && !facts.history.has_come(r.id, w.id);
  const bool awaited = history_first || (owed != 0 && !holds(r.request.begun, w.id));
  const bool reliable = r.qos.reliability == Reliability::reliable;
  const bool attached = holds(r.request.attached, w.id);
  const Announced node{true, w.addresses, w.network == facts.host.self().network};
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

std::vector<Hearing> hearing_of(const TableEntry& reader, const KnownFacts& facts,
                                TypeComparisons& comparisons) {
  std::vector<Hearing> result;
  for (const TableEntry* writer : facts.table.counterparts(reader)) {
    const bool we_write = writer->is_ours();
    const Verdict verdict =
        evaluate({writer->endpoint, reader.endpoint, we_write}, we_write ? *writer->type : *reader.type,
                 facts.host.self(), &comparisons);
    result.push_back(hear(*writer, reader.endpoint, verdict, facts));
  }
  if (result.size() > writers_per_reader_max) hear_no_more_than_possible(result, facts.table);
  return result;
}

}  // namespace sft::core
