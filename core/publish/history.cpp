#include "core/publish/history.h"

#include <algorithm>
#include <utility>

#include "core/platform/clock.h"

namespace sft::core {

History::History(std::uint32_t depth, std::int64_t lifespan_ns)
    : lifespan_ns_(lifespan_ns), samples_(depth) {}

void History::add(const SampleHandle& sample) {
  SampleHandle oldest = sample;
  const Lock lock(mutex_);
  std::swap(samples_[next_], oldest);
  next_ = (next_ + 1) % samples_.size();
}

void History::replace(const SampleHandle& sample) {
  SampleHandle replaced = sample;
  const Lock lock(mutex_);
  for (SampleHandle& kept : samples_) {
    if (kept && kept->sequence == sample->sequence) return std::swap(kept, replaced);
  }
}

bool History::is_expired(const SampleHandle& sample, std::int64_t now_ns) const {
  return lifespan_ns_ != 0 && is_older(sample->source_stamp_ns, lifespan_ns_, now_ns);
}

std::vector<SampleHandle> History::last(std::size_t count, std::int64_t now_ns) const {
  std::vector<SampleHandle> found;
  const Lock lock(mutex_);
  count = std::min(count, samples_.size());
  for (std::size_t i = samples_.size() - count; i < samples_.size(); ++i) {
    const SampleHandle& sample = samples_[(next_ + i) % samples_.size()];
    if (sample && !is_expired(sample, now_ns)) found.push_back(sample);
  }
  return found;
}

void History::expire(std::int64_t now_ns) {
  if (lifespan_ns_ == 0) return;
  std::vector<SampleHandle> gone;
  const Lock lock(mutex_);
  for (SampleHandle& sample : samples_) {
    if (sample && is_expired(sample, now_ns)) gone.push_back(std::move(sample));
  }
}

}  // namespace sft::core
