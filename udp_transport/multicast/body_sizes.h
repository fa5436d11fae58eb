// The sizes of a writer's bodies under each union of a few masks, which the cost model asks for. They are
// measured on samples as these are published, seldom and a little at a time.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "sft/detail/project.h"
#include "udp_transport/multicast/multicast_plan.h"

namespace sft::udp {

class BodySizes {
 public:
  using Time = std::chrono::steady_clock::time_point;
  /// Each set of them is measured.
  static constexpr std::size_t masks_max = 6;

  /// `type` outlives it. Masks are closed.
  BodySizes(const StructType& type, std::vector<FieldMask> masks);

  const std::vector<FieldMask>& masks() const { return masks_; }
  FieldMask union_of(MaskSet set) const;

  /// The publisher's thread: a sample is sent, by itself or of several that are published together.
  void measure(const detail::SampleState& sample, Time now, bool of_several = false) noexcept;

  // Any thread.

  /// All have been measured.
  bool known() const { return known_.load(std::memory_order_acquire); }
  double bytes_of(MaskSet set) const { return bytes_[set].load(std::memory_order_relaxed); }
  std::uint64_t samples() const { return samples_.load(std::memory_order_relaxed); }
  /// Some were published together since last asked.
  bool take_several() { return several_.exchange(false, std::memory_order_relaxed); }

 private:
  static constexpr std::size_t per_sample = 4;
  static constexpr std::chrono::milliseconds pause{100};  ///< between two rounds

  const std::vector<FieldMask> masks_;
  std::vector<detail::ProjectionPlan> plans_;     ///< of set i + 1
  std::unique_ptr<std::atomic<double>[]> bytes_;  ///< by set
  std::atomic<std::uint64_t> samples_{0};
  std::atomic<bool> known_{false}, several_{false};
  // Used by the publisher's thread.
  detail::Projection projection_;
  std::size_t next_ = 0;
  Time round_at_{};
};

}  // namespace sft::udp
