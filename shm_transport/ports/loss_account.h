// Counts the samples of one writer that a reader in shared memory has lost. iceoryx reports that the queue
// has overflowed, but not how many samples were lost. Gaps in the sequence numbers show how many samples
// are missing, but a gap may have another reason: samples that took another path. The overflow and the gap
// together give the number of lost samples. A writer reports an overflow after it has displaced a sample.
// By then the reader may have taken a whole queue of other samples.
//
// The class is not thread-safe: only the thread that takes or drops samples uses it.
#pragma once

#include <cstdint>
#include <utility>

namespace sft::shm {

class LossAccount {
 public:
  /// Notes that iceoryx has reported an overflow of the queue.
  void overflowed() noexcept { overflowed_ = true; }
  /// Notes that the reader itself has dropped the oldest sample of the queue.
  void dropped() noexcept { ++dropped_since_; }

  /// Returns true if the next sample is the first of all samples that the writer has sent to this reader.
  bool nothing_came_before() const noexcept { return last_sequence_ == 0 && !overflowed_; }

  /// Notes that a sample was taken. `popped` is the number of chunks taken out of the queue so far.
  /// `depth()` returns the number of samples that can wait in the queue. Returns the number of samples that
  /// turned out to be lost in the queue before this sample.
  template <class Depth>
  std::uint64_t enter(std::uint64_t sequence, std::uint64_t popped, Depth depth) noexcept {
    const bool overflowed = std::exchange(overflowed_, false);
    std::uint64_t lost = 0;
    if (last_sequence_ == 0) {
      dropped_at_begin_ = dropped_since_;
      lost = 1;  // the first sequence number is not known, so the gap is not known either
    } else if (sequence > last_sequence_ + 1) {
      unexplained_gap_ += sequence - last_sequence_ - 1;
      explicable_ = popped + depth() + 2;
    }
    lost += unexplained_gap_;
    if (overflowed || popped >= explicable_) unexplained_gap_ = 0;
    dropped_since_ = 0;
    last_sequence_ = sequence;
    return overflowed ? lost : 0;
  }

  /// Returns the number of samples that were dropped before the first sample was taken, and after the last
  /// sample was taken. No gap in the sequence numbers shows these.
  std::uint64_t lost_unnoticed() const noexcept { return dropped_at_begin_ + dropped_since_; }

 private:
  bool overflowed_ = false;          ///< true if iceoryx has reported an overflow since the last sample
  std::uint64_t last_sequence_ = 0;  ///< sequence of the last sample that was taken; 0: none was taken
  /// Number of missing sequence numbers for which no overflow was reported yet.
  std::uint64_t unexplained_gap_ = 0;
  std::uint64_t explicable_ = 0;        ///< the value of `popped` up to which an overflow may explain the gap
  std::uint64_t dropped_at_begin_ = 0;  ///< number of samples dropped before the first sample was taken
  std::uint64_t dropped_since_ = 0;     ///< number of samples dropped since the last sample was taken
};

}  // namespace sft::shm
