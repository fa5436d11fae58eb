// The lengths of the bodies of a writer's samples under any mask, and with the parts of fields that readers
// request. The cost model needs these lengths. They are measured from time to time on samples that are being
// published.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "core/sync/published.h"
#include "udp_transport/multicast/leaf_sizes.h"
#include "udp_transport/multicast/part_size.h"

namespace sft::udp {

class BodySizes {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// `type` must outlive this object.
  explicit BodySizes(const StructType& type) : leaves_(type) {}

  /// Measures the sample if `pause` has passed or measure_next() was called. Called by the publisher's
  /// thread for each sample. `of_several` is true if several samples are published by one call. Allocates
  /// nothing.
  void measure(const detail::SampleState& sample, Time now, bool of_several = false) noexcept {
    if (of_several) several_.store(true, std::memory_order_relaxed);
    samples_.fetch_add(1, std::memory_order_relaxed);
    const bool is_asked_for =
        asked_for_.load(std::memory_order_relaxed) && asked_for_.exchange(false, std::memory_order_relaxed);
    if (!is_asked_for && now - measured_at_ < pause) return;
    measured_at_ = now;
    leaves_.measure(sample);
    const Parts* const parts = parts_.load();
    if (parts == nullptr) return;
    for (const auto& part : *parts) part->measure(sample);
  }

  // The following functions are for the agent's thread.

  /// From now on, measures the parts of fields in these selections, and no other parts. `type` must outlive
  /// this object.
  void follow(const TypeSupport& type, std::span<const Selection> selections);
  /// Returns true if all fields of the selection have been measured in samples, and also its parts of
  /// fields. The parts must have been passed to follow().
  bool known(const Selection& selection) const;
  bool known_all(std::span<const Selection> selections) const;
  /// Returns the length of a body with exactly that selection. Parts that were not passed to follow() count
  /// as whole fields.
  double bytes_of(const Selection& selection) const;
  /// Returns the measured size of the selection's parts; null if it has no parts, or was not passed to
  /// follow().
  std::shared_ptr<const PartSize> part_size(const Selection& selection) const;

  // Any thread may call the following functions.

  /// Makes measure() measure the next sample. Called when readers request other fields.
  void measure_next() { asked_for_.store(true, std::memory_order_relaxed); }
  double bytes_of(const FieldMask& fields) const { return leaves_.bytes(fields); }
  std::uint64_t samples() const { return samples_.load(std::memory_order_relaxed); }
  /// Returns true if several samples were published by one call since the last call of this function.
  bool take_several() { return several_.exchange(false, std::memory_order_relaxed); }

 private:
  using Parts = std::vector<std::shared_ptr<PartSize>>;

  static constexpr std::chrono::milliseconds pause{100};

  LeafSizes leaves_;
  std::atomic<std::uint64_t> samples_{0};
  std::atomic<bool> several_{false}, asked_for_{false};
  Time measured_at_{};            ///< used by the publisher's thread
  Parts followed_;                ///< used by the agent's thread
  core::Published<Parts> parts_;  ///< the same as `followed_`, for the publisher's thread
};

}  // namespace sft::udp
