#include "udp_transport/receive/subscriptions.h"

#include <algorithm>
#include <cassert>
#include <set>
#include <string>
#include <unordered_map>
#include <utility>

namespace sft::udp {

namespace {

constexpr std::size_t twins_max = 64;  // maximum number of living writers with the same short id

/// The indices of a stream's selections, by the hashes of the selections. A stream has many selections if
/// many readers change their requests.
using SelectionPlaces = std::unordered_multimap<std::uint64_t, std::size_t>;

void add(const Selection& selection, Stream& stream, SelectionPlaces& places) {
  const std::uint64_t hash = selection.hash();
  const auto [first, last] = places.equal_range(hash);
  const bool is_known = std::any_of(
      first, last, [&](const auto& known) { return stream.selections[known.second] == selection; });
  if (is_known) return;
  places.emplace(hash, stream.selections.size());
  stream.selections.push_back(selection);
}

/// Adds the requests of one reader to the stream of the writer.
void join(Stream& stream, const TypeSupport* type, const core::Source& source,
          const std::vector<core::Accepted>& accepted, SelectionPlaces& places) {
  stream.writer = source.writer;
  stream.type = type;
  stream.reliable = stream.reliable || source.reliable;
  stream.waits = source.waits;
  stream.node = source.node;
  stream.alive = source.alive;
  stream.max_sample_bytes = std::max(stream.max_sample_bytes, source.max_sample_bytes);
  for (const core::Accepted& a : accepted) add(a.wanted.selection, stream, places);
}

}  // namespace

/// A sample for this reader alone is accepted even if its request has ended, because it may have been sent
/// late, after the history. A merged sample has whole fields, from which the reader extracts its parts.
bool Subscriber::accepts(const core::SampleBuffer& sample, std::uint64_t first_request) const {
  const bool for_one = sample.addressee != 0;
  if (for_one && sample.addressee != reader) return false;
  return std::ranges::any_of(*accepted, [&](const core::Accepted& a) {
    const core::Wanted& w = a.wanted;
    if (!for_one && a.request < first_request) return false;
    const FieldMask& mask = w.selection.mask();
    if (core::gate_id(w.selection.gate_hash(), sample.min_period_us) != sample.gate) return false;
    if (sample.merged) return w.min_period_us == 0 && sample.mask.contains(mask);
    if (w.selection.parts_hash() != sample.parts) return false;
    return (for_one || w.min_period_us == sample.min_period_us) && mask == sample.mask;
  });
}

std::uint64_t Subscriber::heard_request() const {
  std::uint64_t last = 0;
  for (const core::Accepted& a : *accepted) last = a.heard ? a.request : last;
  return last;
}

void SubscriptionDirectory::add(core::EndpointId reader, const std::shared_ptr<Inbox>& inbox,
                                const TypeSupport& type) {
  const core::Lock lock(mutex_);
  readers_.push_back({reader, inbox, &type, std::make_shared<const std::vector<core::Accepted>>(), {}});
}

Result<void> SubscriptionDirectory::connect(const Inbox& inbox, const core::Source& source) {
  const core::Lock lock(mutex_);
  Reader& reader = find(inbox);
  if (Result<void> checked = check(reader, source); !checked) return checked;
  std::erase_if(reader.sources, [&](const core::Source& s) { return s.writer == source.writer; });
  reader.sources.push_back(source);
  publish();
  return {};
}

/// Checks that the reader may connect. Datagrams carry only half of the writer's id, and a writer must have
/// one type. A limited number of writers with the same short id are distinguished by their addresses.
Result<void> SubscriptionDirectory::check(const Reader& reader, const core::Source& source) const {
  std::set<core::EndpointId> twins;  // the living writers with that short id
  for (const Reader& other : readers_) {
    for (const core::Source& known : other.sources) {
      if (static_cast<std::uint32_t>(known.writer) != static_cast<std::uint32_t>(source.writer)) continue;
      if (known.writer != source.writer) {
        if (known.alive) twins.insert(known.writer);
        if (twins.size() < twins_max) continue;
        return fail(Errc::unavailable, std::to_string(twins_max) + " writers have the same short id " +
                                           std::to_string(static_cast<std::uint32_t>(source.writer)) +
                                           "; open one of them again to give it another");
      }
      if (other.type->hash() != reader.type->hash()) {
        return fail(Errc::type_mismatch, "the writer is read as " + std::string(other.type->name()) +
                                             " already, not as " + std::string(reader.type->name()) +
                                             " of the same structure");
      }
    }
  }
  return {};
}

void SubscriptionDirectory::announced(const Inbox& inbox, const core::Source& source) {
  const core::Lock lock(mutex_);
  for (core::Source& known : find(inbox).sources) {
    if (known.writer == source.writer) known = source;
  }
  publish();
}

void SubscriptionDirectory::disconnect(const Inbox& inbox, core::EndpointId writer) {
  const core::Lock lock(mutex_);
  std::erase_if(find(inbox).sources, [&](const core::Source& s) { return s.writer == writer; });
  publish();
}

void SubscriptionDirectory::accept(const Inbox& inbox, std::vector<core::Accepted> accepted) {
  auto shared = std::make_shared<const std::vector<core::Accepted>>(std::move(accepted));
  const core::Lock lock(mutex_);
  find(inbox).accepted = std::move(shared);
  publish();
}

void SubscriptionDirectory::remove(const Inbox& inbox) {
  {
    const core::Lock lock(mutex_);
    std::erase_if(readers_, [&](const Reader& r) { return r.inbox.get() == &inbox; });
    publish();
  }
  subscriptions_.wait_for_reader();
}

SubscriptionDirectory::Reader& SubscriptionDirectory::find(const Inbox& inbox) {
  const auto found = std::find_if(readers_.begin(), readers_.end(),
                                  [&](const Reader& r) { return r.inbox.get() == &inbox; });
  assert(found != readers_.end());
  return *found;
}

/// Publishes the subscriptions of the present readers.
void SubscriptionDirectory::publish() {
  auto next = std::make_shared<Subscriptions>();
  std::unordered_map<core::EndpointId, std::size_t> places;
  std::vector<SelectionPlaces> selections;  // one map per stream
  for (const Reader& reader : readers_) {
    for (const core::Source& source : reader.sources) {
      const auto [place, is_new] = places.try_emplace(source.writer, next->streams.size());
      if (is_new) {
        next->streams.emplace_back();
        next->subscribers.emplace_back();
        selections.emplace_back();
      }
      join(next->streams[place->second], reader.type, source, *reader.accepted, selections[place->second]);
      next->subscribers[place->second].push_back({reader.id, reader.inbox, reader.accepted, source.reliable});
    }
  }
  subscriptions_.replace(std::move(next));
}

}  // namespace sft::udp
