#include "core/negotiation/serving.h"

#include <string>
#include <vector>

#include "core/negotiation/id_list.h"
#include "core/negotiation/pair.h"

namespace sft::core {

namespace {

void note_mismatch(const Verdict& verdict, PublisherStatus::Reader& status) {
  status.reason = verdict.mismatch;
  status.mismatch = verdict.definitions;
  status.incompatible_type = verdict.incompatible_type;
  status.incompatible_policy = verdict.incompatible_policy;
}

void serve(const TableEntry& writer, const TableEntry& reader, const Verdict& verdict,
           const KnownFacts& facts, Serving& serving) {
  const Endpoint& r = reader.endpoint;
  const TypeSupport& type = *writer.type;
  PublisherStatus::Reader& status = serving.readers.emplace_back();
  status.id = r.id;
  status.node = r.node;
  status.request_sequence = r.request.sequence;
  if (!verdict.mismatch.empty()) return note_mismatch(verdict, status);
  const Result<Selection>& asked = facts.requested.of({writer.endpoint.id, r.id}, r.request, type);
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
  const std::uint32_t owed = facts.history.owed(writer.endpoint, r);
  const bool history_first = owed != 0 && verdict.network;
  const bool reliable = r.qos.reliability == Reliability::reliable;
  const bool listens = verdict.network && holds(r.request.listening, writer.endpoint.id);
  serving.history_owed |= history_first;
  const bool attached = verdict.memory && !history_first && holds(r.request.attached, writer.endpoint.id);
  const std::string* const unreached = facts.unreachable.why({writer.endpoint.id, r.id});
  const bool unreachable = attached && unreached != nullptr;
  if (unreachable) serving.unreached.push_back({r.id, r.doorbell, *asked, period});
  if (attached && !unreachable) {
    status.served = true;
    status.transport = TransportKind::shm;
    status.reason = "same host";
    const bool begun = holds(r.request.begun, writer.endpoint.id);
    serving.memory.push_back({r.id, r.doorbell, *asked, period, nullptr, begun ? 0 : owed, false, reliable});
    if (listens)
      serving.fallback.push_back(
          {r.id, facts.host.address_of(r), *asked, period, nullptr, 0, true, reliable});
  } else if (listens) {
    status.served = true;
    status.transport = TransportKind::udp;
    status.reason = !verdict.memory ? verdict.network_reason
                    : unreachable   ? *unreached
                    : history_first ? "same host; retained samples come first, by UDP"
                                    : "same host, shared memory is being attached";
    serving.network.push_back(
        {r.id, facts.host.address_of(r), *asked, period, nullptr, owed, false, reliable});
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

}  // namespace

Serving serving_of(const TableEntry& writer, const KnownFacts& facts, TypeComparisons& comparisons) {
  Serving serving;
  const std::vector<const TableEntry*> readers = facts.table.counterparts(writer);
  serving.readers.reserve(readers.size());
  for (const TableEntry* reader : readers) {
    const Verdict verdict =
        evaluate({writer.endpoint, reader->endpoint, true}, *writer.type, facts.host.self(), &comparisons);
    serve(writer, *reader, verdict, facts, serving);
    look_after_lease(reader->endpoint, serving.readers.back(), serving);
  }
  return serving;
}

}  // namespace sft::core
