// Decides which sequences of one writer are believed, since a network can change bits. If one wrong sequence
// were believed, all later valid samples would look late, and a reader would drop them. Uses no clock,
// thread or I/O.
//
// A sequence far from the newest one is believed only if several such sequences come and no sequence near
// the newest one comes between them. If only late samples come, the newest sequence was wrong. In both
// cases, the numbering begins anew. Readers see that by SampleBuffer::numbering of each sample.
#pragma once

#include <chrono>
#include <cstdint>

namespace sft::udp {

class SequenceMonitor {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// A sequence is believed at once if it is greater than the newest one by at most this difference.
  static constexpr std::uint64_t reach = std::uint64_t{1} << 16;
  /// For each second without a datagram of the writer, this number is added to `reach`. No writer publishes
  /// more samples per second.
  static constexpr std::uint64_t published_per_s_max = std::uint64_t{1} << 22;
  /// A sequence that is less than the newest one by more than this difference is far from it, too.
  static constexpr std::uint64_t reach_back = std::uint64_t{1} << 26;
  /// The minimum time between the first datagram that suggests a new numbering and the beginning of that
  /// numbering. Datagrams that the network has delayed usually come at once, within a shorter time.
  static constexpr std::chrono::milliseconds newest_unconfirmed_after{250};
  /// The number of late datagrams in a row that begin a new numbering. They may be repairs, or come by a
  /// slow path, so one is no evidence. But two are enough if their stamps show that they were published
  /// after the newest sample.
  static constexpr std::uint32_t late_in_a_row = 64;

  struct Observed {
    std::uint64_t sequence = 0;
    /// The sample's ordinal in the writer's channel; 0: the sample is in no channel. If the ordinal is less
    /// than that of the newest sample, too, the late sample is a repair.
    std::uint64_t place = 0;
    /// The number of the datagram: unique, and not 0. It ensures that a datagram with several samples does
    /// not confirm itself.
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
  /// steps. If there is no such sequence, the newest sequence takes its place.
  std::uint64_t widen(std::uint32_t low) const;

  std::uint64_t newest() const { return newest_.sequence; }
  /// Must be called only when a numbering has just begun anew. Returns true if all greater sequences than
  /// the new one were certainly wrong. Returns false if only the number of late samples suggests that, since
  /// these may have been repairs.
  bool newest_was_wrong() const { return newest_was_wrong_; }
  /// Returns the number of times that the numbering has begun anew.
  std::uint32_t numbering() const { return numbering_; }

 private:
  /// Consecutive datagrams that suggest the same change of the numbering. Their order is irrelevant, because
  /// datagrams overtake each other, and repairs come between new samples. But the numbering continues only
  /// with a sequence that is greater than the previous one.
  struct Row {
    std::uint32_t datagrams = 0;
    std::uint64_t last = 0;
    Time since{};

    /// Returns true if the sequence is greater than that of the previous datagram.
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
  std::uint32_t small_steps_ = 0;  ///< number of consecutive datagrams that each advanced by a small step
  std::uint64_t steady_ = 0;       ///< newest sequence that was reached by small steps in a row
  std::int64_t steady_stamp_ns_ = 0;
  Time steady_at_{};
  Row far_;                             ///< datagrams with sequences far from the newest one
  Row late_;                            ///< late datagrams
  Row later_;                           ///< late datagrams that were published after the newest sample
  std::uint64_t last_unconfirmed_ = 0;  ///< number of the last datagram in `far_`, `late_` or `later_`
  std::uint32_t numbering_ = 0;
  bool newest_was_wrong_ = false;
};

}  // namespace sft::udp
