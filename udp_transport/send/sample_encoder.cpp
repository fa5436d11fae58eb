#include "udp_transport/send/sample_encoder.h"

#include <cassert>

namespace sft::udp {

bool SampleEncoder::encode(const Audience& audience, const core::SampleBuffer& sample, Job& job) const {
  assert(sample.mask.contains(audience.plan.mask()));
  if (!project(audience, sample, job.projection)) return false;
  if (job.projection.bytes() > side_->max_sample_bytes) {
    side_->over_limit.fetch_add(1, std::memory_order_relaxed);
    return false;
  }
  describe(audience, sample, job);
  job.first.total = static_cast<std::uint32_t>(job.projection.bytes());
  return true;
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
