// Decides which samples of a durable writer a late reader takes. The writer first sends samples for this
// reader alone: those that it had retained, and those that it published meanwhile. Samples for all readers
// can arrive earlier, because other readers of the process may have the same mask. They must not overtake
// the samples for this reader alone. Uses no clock, thread or I/O.
#pragma once

#include <chrono>
#include <cstdint>

#include "core/seam/transport.h"

namespace sft::udp {

class LateFilter {
 public:
  using Time = std::chrono::steady_clock::time_point;
  /// If no sample for this reader alone has come for this time, it is assumed that no such sample is under
  /// way.
  static constexpr std::chrono::milliseconds settling{100};

  /// If `history_first` is false, the reader takes every sample at once.
  explicit LateFilter(bool history_first = false) : waits_(history_first), history_first_(history_first) {}

  bool is_late() const { return history_first_; }
  /// Returns true if the reader takes `sample`, which has arrived. A sample for all readers is taken if it
  /// directly follows the last taken sample, or if no sample for this reader alone is under way.
  bool takes(const core::SampleBuffer& sample, Time now);
  core::HistoryProgress progress(Time now) const;

 private:
  bool follows(const core::SampleBuffer& sample) const;

  bool waits_;  ///< true until a sample for this reader alone has come
  bool history_first_;
  Time alone_at_{};  ///< time of the last sample for this reader alone
  // The following members describe the newest sample that was taken.
  std::uint64_t sequence_ = 0;
  std::uint32_t min_period_us_ = 0;
  std::uint64_t gate_ = 0;
  std::uint32_t ordinal_ = 0;
  std::uint32_t numbering_ = 0;
};

}  // namespace sft::udp
