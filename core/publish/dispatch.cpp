#include "core/publish/dispatch.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "core/publish/lent_copy.h"
#include "core/seam/gate_table.h"
#include "sft/detail/misuse.h"

namespace sft::core {

namespace {

bool is_among(const std::vector<Route>& routes, const Route& to) {
  return std::ranges::find(routes, to.reader, &Route::reader) != routes.end();
}

/// Returns the routes of `some`, and the routes of `others` to readers that have no route in `some`.
std::vector<Route> joined(const std::vector<Route>& some, const std::vector<Route>& others) {
  std::vector<Route> all = some;
  const auto is_new = [&](const Route& route) { return !is_among(some, route); };
  std::ranges::copy_if(others, std::back_inserter(all), is_new);
  return all;
}

/// Returns the routes of `before` to readers to which `elsewhere` also has routes.
std::vector<Route> changing_over(const std::vector<Route>& before, const std::vector<Route>& elsewhere) {
  std::vector<Route> some;
  const auto is_elsewhere = [&](const Route& route) { return is_among(elsewhere, route); };
  std::ranges::copy_if(before, std::back_inserter(some), is_elsewhere);
  return some;
}

}  // namespace

Dispatch::Dispatch(Setup setup)
    : type_(*setup.type),
      network_(std::move(setup.network)),
      book_(std::move(setup.book)),
      history_(setup.history),
      waits_(setup.waits),
      postpones_(network_ != nullptr && history_ == nullptr && network_->takes_postponed()),
      topic_(std::move(setup.topic)),
      gates_(type_) {
  outlets_.replace(
      make_outlets(type_, {}, gates_, {nullptr, network_ != nullptr, nullptr, history_ != nullptr}));
}

void Dispatch::stop_second_thread() const noexcept {
  detail::stop_misuse("topic '" + topic_ +
                      "': two threads publish with one publisher at the same time: give each thread a "
                      "publisher of its own, or guard this one with a mutex");
}

/// Makes these outlets the ones by which the publisher's thread sends and counts. If the outlets do not use
/// the network, begin() is called once, so that the network port replaces its page of counts, too, and no
/// longer counts for former readers.
void Dispatch::turn_to(const Outlets& outlets) noexcept {
  book_->turn_to(DeliveryBook::Origin::publisher, outlets.page);
  if (network_ != nullptr && !outlets.to_network) static_cast<void>(network_->begin());
  in_force_ = &outlets;
}

/// Puts outlets in force by which samples are sent to the ports of `before` and also to those of `after`.
void Dispatch::send_by_both(const Outlets& before, const Outlets& after) {
  auto both = std::make_shared<Outlets>(before.with(after));
  if (after.memory != nullptr) {
    both->to_memory = after.to_memory || (before.to_memory && before.memory == after.memory);
    both->memory = after.memory;
  }
  both->to_network |= after.to_network;
  outlets_.replace(std::move(both));
  outlets_.wait_for_reader();
}

FieldMask Dispatch::serve(Serving& serving, std::shared_ptr<LendingWriter> memory,
                          std::shared_ptr<VanillaPort> vanilla) {
  gates_.tidy();
  for (auto* routes : {&serving.memory, &serving.network, &serving.fallback}) gates_.give(*routes);
  const std::shared_ptr<Outlets> after =
      make_outlets(type_, serving, gates_,
                   {std::move(memory), network_ != nullptr, std::move(vanilla), history_ != nullptr});
  const std::shared_ptr<const Outlets> before = outlets_.share();
  if (!before->provides_for(*after)) {
    // A route must never need a field that is not encoded, or a gate that was not asked. So this takes
    // three steps. First, outlets that suffice for the old and the new routes are put in force. Then the
    // agent waits for the end of a Call that may have begun earlier. Only after that are the routes
    // replaced.
    outlets_.replace(std::make_shared<Outlets>(before->with(*after)));
    outlets_.wait_for_reader();
  }
  book_->enter(after->page);
  // A reader that changes from one port to the other must not miss samples. So for a moment both ports send
  // samples to the reader, and it takes each sample only once.
  const std::vector<Route> leave_memory = changing_over(in_memory_, serving.network);
  const std::vector<Route> leave_network = changing_over(over_network_, serving.memory);
  std::vector<Route> network = serving.network;
  if (after->has_fallback) network.insert(network.end(), serving.fallback.begin(), serving.fallback.end());
  if (network_ != nullptr && !leave_memory.empty()) network_->set_routes(joined(leave_network, network));
  if (after->memory != nullptr) after->memory->set_routes(joined(leave_memory, serving.memory));
  if (!leave_memory.empty() || !leave_network.empty()) send_by_both(*before, *after);
  if (after->memory != nullptr && !leave_memory.empty()) after->memory->set_routes(serving.memory);
  if (network_ != nullptr) network_->set_routes(std::move(network));
  outlets_.replace(after);
  gates_.open_for(serving);
  in_memory_ = serving.memory;
  over_network_ = serving.network;
  return after->is_wanted ? after->mask : type_.none();
}

Dispatch::Admission Dispatch::admit(const SampleHandle& sample, std::int64_t stamp_ns) noexcept {
  if (!sample) return admit(detail::FieldSource::of_nothing(), stamp_ns);
  const detail::SampleState state = state_of(*sample, type_.index_slots());
  const auto fields = detail::FieldSource::of_sample(state);
  Admission admission = admit(fields, stamp_ns);
  made(fields, stamp_ns);
  return admission;
}

PublishStatus Dispatch::miss(Admission&& admission, std::uint32_t body_bytes) noexcept {
  const Outlets& outlets = *in_force_;
  sequence_.fetch_add(1, std::memory_order_relaxed);
  dropped_.fetch_add(1, std::memory_order_relaxed);
  for (const Outlets::MemoryGroup& group : outlets.memory_groups) {
    if (group.wants_sample()) group.tally->dropped();
  }
  if (outlets.to_network) {
    if (!admission.transmission) admission.transmission.emplace(network_->begin());
    (*std::move(admission.transmission)).miss();
  }
  if (outlets.to_memory) count_refusal(body_bytes);
  return PublishStatus::no_memory;
}

/// Counts a sample for which shared memory could not lend memory, according to the reason. `body_bytes` is
/// the size of its body.
void Dispatch::count_refusal(std::uint32_t body_bytes) noexcept {
  const std::size_t bytes = detail::SampleLayout(type_.index_slots()).bytes(body_bytes);
  const std::size_t chunk_bytes = in_force_->memory->largest_loan_bytes();
  const bool is_too_large = bytes > chunk_bytes;
  (is_too_large ? refusals_.too_large : refusals_.exhausted).fetch_add(1, std::memory_order_relaxed);
  if (!is_too_large || bytes <= refusals_.too_large_bytes.load(std::memory_order_relaxed)) return;
  refusals_.too_large_bytes.store(bytes, std::memory_order_relaxed);
  refusals_.chunk_bytes.store(chunk_bytes, std::memory_order_relaxed);
}

PublishStatus Dispatch::send(const SampleHandle& sample, std::int64_t stamp_ns, Admission&& admission,
                             std::chrono::nanoseconds& timeout) noexcept {
  detail::SampleHeader& header = sample->header();
  header.sequence = sequence_.fetch_add(1, std::memory_order_relaxed) + 1;
  header.source_stamp_ns = stamp_ns;
  header.diverted_sequence = diverted_sequence_;
  header.diverted_stamp_ns = diverted_stamp_ns_;
  sample->trust_header();
  if (history_ != nullptr) {
    history_->add(sample);
    look_at_outlets();  // the outlets may have changed, and are read again for the reason in late_readers.h
  }
  const Outlets& outlets = *in_force_;
  PublishStatus status = PublishStatus::ok;
  Reach reach = Reach::usual_routes;
  if (outlets.to_memory) {
    const SendStatus there = send_to_memory(sample, timeout);
    if (there == SendStatus::displaced) status = PublishStatus::dropped;
    if (there == SendStatus::sent || there == SendStatus::displaced) {
      for (const Outlets::MemoryGroup& group : outlets.memory_groups) {
        if (group.wants_sample()) group.tally->sent(0, 0);
      }
    } else {
      status = divert(*sample);
      if (outlets.has_fallback) reach = Reach::fallback_routes_too;
    }
  }
  if (outlets.to_network && !outlets.to_memory) note_sent_over_network_alone(*sample);
  if (outlets.to_network || reach == Reach::fallback_routes_too) {
    if (waits_) network_->set_timeout(timeout);
    if (send_over_network(sample, reach, admission.transmission) != SendStatus::sent)
      status = PublishStatus::dropped;
  }
  if (outlets.vanilla != nullptr) outlets.vanilla->send(sample);
  if (status != PublishStatus::ok) dropped_.fetch_add(1, std::memory_order_relaxed);
  return status;
}

/// Sends the sample by shared memory. A sample that lies in other memory is copied first. Such a sample was
/// made before shared memory was available, or while no chunk was free.
SendStatus Dispatch::send_to_memory(const SampleHandle& sample, std::chrono::nanoseconds& timeout) noexcept {
  LendingWriter& memory = *in_force_->memory;
  const std::span gates(in_force_->memory_gates);
  SampleHandle lent = sample;
  if (!memory.can_send(*sample)) lent = copy_into(memory, *sample, type_, gate_table_bytes(gates.size()));
  if (!lent && !gates.empty()) lent = copy_into(memory, *sample, type_);
  if (!lent) {
    count_refusal(sample->header().body_bytes);
    return SendStatus::dropped;
  }
  if (!gates.empty()) write_gate_table(*lent, type_.index_slots(), gates);
  if (waits_) memory.set_timeout(timeout);
  const SendStatus status = memory.send(lent);
  if (waits_) timeout = memory.time_left();
  if (status != SendStatus::sent && status != SendStatus::displaced)
    refusals_.unavailable.fetch_add(1, std::memory_order_relaxed);
  return status;
}

/// Called if shared memory does not take the sample. Counts the sample as dropped for the readers that have
/// no fallback route.
PublishStatus Dispatch::divert(const SampleBuffer& sample) noexcept {
  if (in_force_->has_fallback) note_sent_over_network_alone(sample);
  PublishStatus status = PublishStatus::ok;
  for (const Outlets::MemoryGroup& group : in_force_->memory_groups) {
    if (group.have_fallback || !group.wants_sample()) continue;
    group.tally->dropped();
    status = PublishStatus::dropped;
  }
  return status;
}

std::optional<Batch> Dispatch::batch(BatchTimeout timeout) noexcept {
  std::optional<Batch> batch;
  if (network_ != nullptr) batch.emplace(network_->batch(timeout));
  return batch;
}

PublisherStatus::Diverted Dispatch::diverted() const noexcept {
  const auto read = [](const std::atomic<std::uint64_t>& count) {
    return count.load(std::memory_order_relaxed);
  };
  return {read(refusals_.exhausted), read(refusals_.too_large), read(refusals_.unavailable),
          read(refusals_.too_large_bytes), read(refusals_.chunk_bytes)};
}

}  // namespace sft::core
