#include "udp_transport/receive/sample_assembly.h"

#include <algorithm>
#include <utility>

namespace sft::udp {

SampleAssembly::~SampleAssembly() {
  unfinished_.forget_places();
  while (!unfinished_.empty()) remove(SampleLabel(unfinished_.loose().back()->label()));
}

UnfinishedSample& SampleAssembly::begin(const SampleLabel& label, std::uint64_t place, Time now) {
  const auto& loose = unfinished_.loose();
  const auto of_variant = [&] {
    return static_cast<std::size_t>(std::ranges::count_if(
        loose, [&](const auto& sample) { return sample->label().variant == label.variant; }));
  };
  const ReassemblyLimits& limits = shared_.limits;
  const auto full = [&] {
    return loose.size() >= limits.unfinished_per_writer || of_variant() >= limits.unfinished_per_variant;
  };
  while (place == 0 && full() && drop_oldest(label)) {
  }
  return unfinished_.add(shared_.begin_sample(label, place, now));
}

void SampleAssembly::describe(UnfinishedSample& sample, const FirstHeader& first, std::size_t body_offset,
                              core::SampleHandle buffer) {
  sample.describe(first, body_offset, std::move(buffer));
  described_bytes_ += first.total;
}

SampleAssembly::Parked SampleAssembly::park(UnfinishedSample& sample, const Following& d,
                                            std::size_t sample_bytes, Time now) {
  if (d.payload.size() > sample_bytes || d.offset > sample_bytes - d.payload.size())
    return Parked::beyond_body;
  const std::size_t bytes = UnfinishedSample::bytes_to_park(d.payload);
  if (!shared_.can_park(bytes)) return Parked::over_limit;
  sample.park(d.offset, d.payload, now);
  shared_.note_parked(bytes);
  return Parked::yes;
}

UnfinishedSample::Added SampleAssembly::unpark(UnfinishedSample& sample, Time now) {
  shared_.note_unparked(sample.parked_bytes());
  return sample.unpark(shared_.limits.gaps, now);
}

UnfinishedSamples::Handle SampleAssembly::remove(const SampleLabel& label) {
  UnfinishedSamples::Handle sample = unfinished_.remove(label);
  if (sample == nullptr) return nullptr;
  if (sample->described()) described_bytes_ -= sample->first().total;
  shared_.note_removed(*sample);
  return sample;
}

void SampleAssembly::give_back(const SampleLabel& label) {
  if (UnfinishedSamples::Handle sample = remove(label)) shared_.recycle(std::move(sample));
}

std::uint64_t SampleAssembly::drop(const SampleLabel& label, std::uint64_t& counter) {
  ++counter;
  finished_.add(label);
  UnfinishedSamples::Handle sample = remove(label);
  if (sample == nullptr) return 0;
  const std::uint64_t place = sample->place();
  shared_.recycle(std::move(sample));
  return place;
}

/// Drops the oldest sample of the same variant as `same_variant_first`, or the oldest one of any variant if
/// that variant has no other. Never drops the sample with that label or a reliable sample. Returns false if
/// no sample can be dropped.
bool SampleAssembly::drop_oldest(const SampleLabel& same_variant_first) {
  const UnfinishedSample* oldest = nullptr;
  for (const auto& sample : unfinished_.loose()) {
    if (sample->label() == same_variant_first) continue;
    const bool same_variant = sample->label().variant == same_variant_first.variant;
    if (oldest == nullptr || same_variant) oldest = sample.get();
    if (same_variant) break;
  }
  if (oldest != nullptr) drop(SampleLabel(oldest->label()), shared_.counters.incomplete);
  return oldest != nullptr;
}

void SampleAssembly::expire(Time now, std::optional<Time>& next) {
  const auto& loose = unfinished_.loose();
  for (std::size_t i = 0; i < loose.size();) {
    const Time expiry = loose[i]->last_progress() + shared_.limits.timeout;
    if (expiry <= now) {
      drop(SampleLabel(loose[i]->label()), shared_.counters.incomplete);
    } else {
      next = next ? std::min(*next, expiry) : expiry;
      ++i;
    }
  }
}

void SampleAssembly::forget_places() {
  unfinished_.forget_places();
  if (!unfinished_.empty()) shared_.set_next_expiry(Time{});
}

core::SampleHandle SampleAssembly::take_buffer(std::size_t buffer_bytes, const SampleLabel& label,
                                               std::size_t body_bytes, bool is_whole) {
  while (!is_whole && described_bytes_ + body_bytes > shared_.limits.unfinished_bytes && drop_oldest(label)) {
  }
  const std::size_t reserved_bytes = shared_.reserved_for_publishers();
  core::SampleHandle buffer = shared_.pool->take(buffer_bytes, reserved_bytes);
  while (!buffer && drop_oldest(label)) buffer = shared_.pool->take(buffer_bytes, reserved_bytes);
  return buffer;
}

core::SampleHandle SampleAssembly::take_reliable_buffer(std::size_t buffer_bytes, std::size_t body_bytes,
                                                        std::size_t reserved_bytes) {
  if (described_bytes_ > 0 && described_bytes_ + body_bytes > shared_.limits.unfinished_bytes) return {};
  return shared_.pool->take(buffer_bytes, shared_.reserved_for_publishers() + reserved_bytes);
}

}  // namespace sft::udp
