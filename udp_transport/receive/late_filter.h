// What a late reader takes of a durable writer. First comes what is for it alone: what the writer had
// retained, and what is live behind that. Others in its process may share its mask, and what is live for them
// must not overtake any of it. Pure: samples and times in, answers out.
#pragma once

#include <chrono>
#include <cstdint>

#include "core/seam/transport.h"

namespace sft::udp {

class LateFilter {
 public:
  using Time = std::chrono::steady_clock::time_point;
  /// Nothing for it alone is under way any more if none has come for so long.
  static constexpr std::chrono::milliseconds settling{100};

  /// Without `history_first` all is taken, at once.
  explicit LateFilter(bool history_first = false) : waits_(history_first), history_first_(history_first) {}

  bool is_late() const { return history_first_; }
  /// Whether the reader takes a sample that has arrived. What is for all it takes while that is the very next
  /// one, or once nothing for it alone is under way.
  bool takes(const core::SampleBuffer& sample, Time now);
  core::HistoryProgress progress(Time now) const;

 private:
  bool follows(const core::SampleBuffer& sample) const;

  bool waits_;  ///< until something for it alone has come
  bool history_first_;
  Time alone_at_{};  ///< when the last such sample came
  // Of the newest sample that was taken:
  std::uint64_t sequence_ = 0;
  std::uint32_t min_period_us_ = 0;
  std::uint32_t ordinal_ = 0;
  std::uint32_t numbering_ = 0;
};

}  // namespace sft::udp
