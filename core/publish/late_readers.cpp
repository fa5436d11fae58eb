#include "core/publish/late_readers.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "core/platform/clock.h"
#include "core/publish/lent_copy.h"
#include "sft/detail/conditions.h"

namespace sft::core {

LateReaders::LateReaders(const TypeSupport& type, std::shared_ptr<NetworkWriter> network,
                         std::shared_ptr<DeliveryBook> book, History* history)
    : type_(type), network_(std::move(network)), book_(std::move(book)), history_(history) {}

void LateReaders::serve(const Serving& serving, std::shared_ptr<LendingWriter> memory) {
  for (const Route& route : take_latecomers(serving)) {
    std::vector<SampleHandle> samples = retained_for(route);
    book_->retained(route.reader, samples.size());
    network_->send_history(route, std::move(samples));
  }
  memory_ = std::move(memory);
  late_in_memory_.clear();
  std::ranges::copy_if(serving.memory, std::back_inserter(late_in_memory_),
                       [](const Route& route) { return route.history != 0; });
  give_history();
}

/// Returns the routes of readers to which the history must be sent over the network now, because the
/// history was not sent to their present addresses yet.
std::vector<Route> LateReaders::take_latecomers(const Serving& serving) {
  std::vector<Route> latecomers;
  std::map<EndpointId, Locator> begun;
  for (const Route& route : serving.network) {
    if (route.history == 0) continue;
    begun.emplace(route.reader, route.destination);
    const auto before = begun_.find(route.reader);
    if (before == begun_.end() || before->second != route.destination) latecomers.push_back(route);
  }
  begun_ = std::move(begun);
  return latecomers;
}

void LateReaders::give_history() {
  constexpr int attempts = 20;  // an attempt fails if a sample is published during it
  for (const Route& route : late_in_memory_) {
    for (int i = 0; memory_ != nullptr && i < attempts && !give_history(*memory_, route); ++i) continue;
  }
}

/// Sends the history to one reader. Returns true if this has succeeded. The number of samples held back is
/// read first, so that these samples are contained in the history, which is read after that.
bool LateReaders::give_history(LendingWriter& memory, const Route& route) {
  const auto held_back = memory.held_back(route.reader);
  if (!held_back) return true;
  const std::vector<SampleHandle> samples = retained_in(memory, route);
  if (!memory.begin_with(route, samples, *held_back)) return false;
  book_->retained(route.reader, samples.size());
  return true;
}

/// Returns the retained samples that fulfil the conditions of the reader. The conditions are evaluated as for
/// a reader that has not received any sample before.
std::vector<SampleHandle> LateReaders::retained_for(const Route& route) const {
  std::vector<SampleHandle> samples = history_->last(route.history, realtime_ns());
  if (route.selection.gate().conditions.empty()) return samples;
  detail::Conditions conditions(type_.type(), route.selection.gate().conditions);
  std::vector<SampleHandle> wanted;
  for (SampleHandle& sample : samples) {
    const detail::SampleState state = state_of(*sample, type_.index_slots());
    const auto fields = detail::FieldSource::of_sample(state);
    if (!conditions.hold(fields, sample->source_stamp_ns)) continue;
    conditions.passed(fields, sample->source_stamp_ns);
    wanted.push_back(std::move(sample));
  }
  return wanted;
}

/// Returns the retained samples in shared memory. Samples that were published before there was shared
/// memory are copied now. A sample for which no memory is free is left out, and counts as missed.
std::vector<SampleHandle> LateReaders::retained_in(LendingWriter& memory, const Route& route) {
  std::vector<SampleHandle> samples = retained_for(route);
  for (SampleHandle& sample : samples) {
    if (memory.owns(*sample)) continue;
    sample = copy_into(memory, *sample, type_);
    sample ? history_->replace(sample) : static_cast<void>(missed_.fetch_add(1, std::memory_order_relaxed));
  }
  std::erase_if(samples, [](const SampleHandle& sample) { return !sample; });
  return samples;
}

}  // namespace sft::core
