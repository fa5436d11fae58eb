#include "udp_transport/multicast/body_sizes.h"

#include <new>
#include <utility>

namespace sft::udp {

BodySizes::BodySizes(const StructType& type, std::vector<FieldMask> masks)
    : masks_(std::move(masks)),
      bytes_(std::make_unique<std::atomic<double>[]>(std::size_t{1} << masks_.size())) {
  for (MaskSet set = 1; set < MaskSet{1} << masks_.size(); ++set) plans_.emplace_back(type, union_of(set));
}

FieldMask BodySizes::union_of(MaskSet set) const {
  FieldMask all(masks_.front().leaves());
  for (std::size_t i = 0; i < masks_.size(); ++i) {
    if ((set >> i & 1) != 0) all |= masks_[i];
  }
  return all;
}

/// Each new value counts for a quarter.
void BodySizes::measure(const detail::SampleState& sample, Time now, bool of_several) noexcept try {
  if (of_several) several_.store(true, std::memory_order_relaxed);
  samples_.fetch_add(1, std::memory_order_relaxed);
  if (next_ == 0 && now - round_at_ < pause) return;
  if (next_ == 0) round_at_ = now;
  for (std::size_t n = 0; n < per_sample && next_ < plans_.size(); ++n, ++next_) {
    if (!projection_.project(sample, plans_[next_])) continue;
    std::atomic<double>& smoothed = bytes_[next_ + 1];
    const double before = smoothed.load(std::memory_order_relaxed);
    const auto bytes = static_cast<double>(projection_.bytes());
    smoothed.store(known() ? before + (bytes - before) / 4 : bytes, std::memory_order_relaxed);
  }
  if (next_ < plans_.size()) return;
  next_ = 0;
  known_.store(true, std::memory_order_release);
} catch (const std::bad_alloc&) {  // it grows with the samples that it has seen
}

}  // namespace sft::udp
