// Decides which samples of a durable writer a late reader takes. Samples for this reader alone come first:
// those that the writer had retained, and live ones that were published meanwhile. Other readers in the
// process may have the same mask. Live samples for all of them must not overtake those for this reader
// alone. Uses no clock, thread or I/O.
#pragma once

#include <chrono>
#include <cstdint>

#include "core/seam/transport.h"

namespace sft::udp {

class LateFilter {
 public:
  using Time = std::chrono::steady_clock::time_point;
  /// If no sample for this reader alone has come for this time, no such sample is under way any more.
  static constexpr std::chrono::milliseconds settling{100};

  /// Without `history_first` the reader takes every sample at once.
  explicit LateFilter(bool history_first = false) : waits_(history_first), history_first_(history_first) {}

  bool is_late() const { return history_first_; }
  /// Returns true if the reader takes a sample that has arrived. A sample for all readers is taken if it is
  /// the very next one, or if no sample for this reader alone is under way.
  bool takes(const core::SampleBuffer& sample, Time now);
  core::HistoryProgress progress(Time now) const;

 private:
  bool follows(const core::SampleBuffer& sample) const;

  bool waits_;  ///< true if no sample for this reader alone has come yet
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
