// Decides which sequences of one writer count, since a network can change bits. One wrong number must not
// make a reader drop valid samples, all of which would look late after it. Uses no clock, thread or I/O.
//
// A sequence far from the newest one counts only if no near sequences come between such sequences. If only
// late samples come, the newest sequence was wrong. In both cases the numbering begins anew, and
// SampleBuffer::numbering of each sample tells the readers so.
#pragma once

#include <chrono>
#include <cstdint>

namespace sft::udp {

class SequenceMonitor {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// A sequence that is ahead of the newest one by less than this counts at once.
  static constexpr std::uint64_t reach = std::uint64_t{1} << 16;
  /// While no datagram of the writer comes, this number is added to `reach` for each second. No writer
  /// publishes more.
  static constexpr std::uint64_t published_per_s_max = std::uint64_t{1} << 22;
  /// A sequence that is behind the newest one by more than this is far from it, too.
  static constexpr std::uint64_t reach_back = std::uint64_t{1} << 26;
  /// The least time between the first datagram that suggests a new numbering and its beginning. Datagrams
  /// that were delayed on the way come all at once, within a shorter time.
  static constexpr std::chrono::milliseconds newest_unconfirmed_after{250};
  /// Two late datagrams are enough if their stamps show that they were published after the newest sample.
  /// Other late datagrams, which may be repairs or come by a slow path, are needed in this number.
  static constexpr std::uint32_t late_in_a_row = 64;

  struct Observed {
    std::uint64_t sequence = 0;
    /// The sample's place in the channel of the writer; 0: it is in no channel. If the place is behind the
    /// newest one, too, the sample is a repair.
    std::uint64_t place = 0;
    /// The number of the datagram, different for each and not 0. A datagram must not confirm itself.
    std::uint64_t datagram = 0;
    std::int64_t stamp_ns = 0;  ///< time of publishing, by the writer's clock
  };
  /// Returns true if a sample with these values may be delivered.
  bool accepts(const Observed& observed, Time now) {
    const bool is_next =
        newest() != 0 && observed.sequence > newest() && observed.sequence - newest() <= reach;
    if (!is_next) [[unlikely]]
      return evaluate(observed, now);
    advance(observed, now);
    return true;
  }
  /// Returns the 64-bit sequence with these low bits that is nearest to the last sequence reached in small
  /// steps, or else to the newest sequence.
  std::uint64_t widen(std::uint32_t low) const;

  std::uint64_t newest() const { return newest_.sequence; }
  /// Called when a numbering has just begun anew. Returns true if all sequences above the new one were
  /// certainly wrong. If only the number of late samples suggests that, these may have been repairs.
  bool newest_was_wrong() const { return newest_was_wrong_; }
  /// Returns the number of times that the numbering has begun anew.
  std::uint32_t numbering() const { return numbering_; }

 private:
  /// Datagrams in a row that suggest the same change. Their order means nothing, because datagrams overtake
  /// each other, and repairs come between new samples. But a numbering continues with a new sequence.
  struct Row {
    std::uint32_t datagrams = 0;
    std::uint64_t last = 0;
    Time since{};

    /// Returns true if the sequence is above that of the previous datagram.
    bool add(std::uint64_t sequence, Time now);
    bool lasts(Time now) const { return now - since >= newest_unconfirmed_after; }
  };

  bool evaluate(const Observed& observed, Time now);
  bool evaluate_far(const Observed& observed, Time now);
  void evaluate_late(const Observed& observed, Time now);
  void advance(const Observed& observed, Time now);
  void count_step(const Observed& observed, Time now);
  void begin_anew(const Observed& observed, Time now, bool newest_was_wrong);
  bool is_younger(const Observed& observed) const;

  Observed newest_{};  ///< the newest sample; its sequence is 0 if there is none yet
  Time advanced_at_{};
  static constexpr std::uint64_t small_step = 64;
  static constexpr std::uint32_t steady_steps = 4;
  std::uint32_t small_steps_ = 0;  ///< number of small steps in a row, from datagram to datagram
  std::uint64_t steady_ = 0;       ///< newest sequence reached by small steps in a row
  std::int64_t steady_stamp_ns_ = 0;
  Time steady_at_{};
  Row far_;                             ///< datagrams with sequences far from the newest one
  Row late_;                            ///< late datagrams
  Row later_;                           ///< late datagrams that were published after the newest sample
  std::uint64_t last_unconfirmed_ = 0;  ///< number of the last datagram in any of these rows
  std::uint32_t numbering_ = 0;
  bool newest_was_wrong_ = false;
};

}  // namespace sft::udp
