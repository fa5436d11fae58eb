#include "udp_transport/send/sample_encoder.h"

#include <cassert>

namespace sft::udp {

bool SampleEncoder::encode(const Audience& audience, const core::SampleBuffer& sample, Job& job) const {
  assert(sample.mask.contains(audience.plan.mask()));
  const bool ok =
      audience.plan.has_parts() ? gather(audience, sample, job) : project(audience, sample, job.projection);
  if (!ok) return false;
  if (job.projection.bytes() > side_->max_sample_bytes) {
    side_->over_limit.fetch_add(1, std::memory_order_relaxed);
    job.sample.reset();
    return false;
  }
  describe(audience, sample, job);
  job.first.total = static_cast<std::uint32_t>(job.projection.bytes());
  return true;
}

/// Encodes a selection with parts of fields. Large parts are stored in memory of the node's pool. Otherwise
/// each of many jobs would keep a large memory of its own.
bool SampleEncoder::gather(const Audience& audience, const core::SampleBuffer& sample, Job& job) const {
  const detail::SampleState state = core::state_of(sample, type_.index_slots());
  const std::size_t bytes = job.projection.bytes_most(state, audience.plan);
  core::SampleHandle memory;
  if (bytes >= detail::reference_bytes_min && side_->pool != nullptr) memory = side_->pool->take(bytes);
  if (memory &&
      job.projection.project(state, audience.plan, {memory->data, memory->capacity}, sample.postponed)) {
    job.sample = std::move(memory);
    return true;
  }
  return job.projection.project(state, audience.plan, {}, sample.postponed);
}

void SampleEncoder::number(const Audience& audience, Job& job) {
  if (audience.gate == nullptr) return;
  job.first.flags |= rate_follows;
  job.first.rate = {audience.gate->min_period_us(), audience.gate->ordinal()};
}

void SampleEncoder::describe(const Audience& audience, const core::SampleBuffer& sample, Job& job) const {
  job.mask = audience.wire;
  job.sequence = sample.sequence;
  job.whole_bytes = sample.whole_bytes;
  job.first.label = {writer_, static_cast<std::uint32_t>(sample.sequence), audience.wire->variant};
  job.first.flags = audience.wire->words.empty() ? std::uint8_t{0} : mask_words_follow;
  if (audience.merged) job.first.flags |= merged_masks;
  if (audience.late_reader != 0) job.first.flags |= history_follows;
  job.first.history.reader = audience.late_reader;
  job.first.mask = audience.wire->mask;
  job.first.stamp_ns = sample.source_stamp_ns;
}

}  // namespace sft::udp
