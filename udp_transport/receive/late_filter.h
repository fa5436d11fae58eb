// Decides which samples of a durable writer a late reader takes. First come the samples for this reader
// alone: those that the writer had retained, and the live ones behind them. Other readers in the process may
// share the mask, and their live samples must not overtake any of these. Pure: samples and times in, answers
// out.
#pragma once

#include <chrono>
#include <cstdint>

#include "core/seam/transport.h"

namespace sft::udp {

class LateFilter {
 public:
  using Time = std::chrono::steady_clock::time_point;
  /// If no sample for this reader alone has come for so long, none is under way any more.
  static constexpr std::chrono::milliseconds settling{100};

  /// A reader without `history_first` takes every sample at once.
  explicit LateFilter(bool history_first = false) : waits_(history_first), history_first_(history_first) {}

  bool is_late() const { return history_first_; }
  /// True if the reader takes a sample that has arrived. It takes a sample for all readers if that is the
  /// very next one, or if no sample for this reader alone is under way.
  bool takes(const core::SampleBuffer& sample, Time now);
  core::HistoryProgress progress(Time now) const;

 private:
  bool follows(const core::SampleBuffer& sample) const;

  bool waits_;  ///< no sample for this reader alone has come yet
  bool history_first_;
  Time alone_at_{};  ///< when the last such sample came
  // The newest sample that was taken:
  std::uint64_t sequence_ = 0;
  std::uint32_t min_period_us_ = 0;
  std::uint64_t gate_ = 0;
  std::uint32_t ordinal_ = 0;
  std::uint32_t numbering_ = 0;
};

}  // namespace sft::udp
