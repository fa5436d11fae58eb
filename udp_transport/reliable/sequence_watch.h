// Decides which sequences of one writer are believed. One wrong number must not make a reader deaf: all true
// samples would look late behind it. Pure: numbers and times in, answers out.
//
// A sequence far from the newest one counts only when another datagram with a sequence near it confirms it.
// If only late samples arrive, and their sequences ascend, then the newest sequence was wrong. In both cases
// the numbering begins anew, which each sample tells its readers (SampleBuffer::numbering).
#pragma once

#include <chrono>
#include <cstdint>

#include "udp_transport/reliable/ascending_row.h"

namespace sft::udp {

class SequenceWatch {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// A sequence that is less than this ahead of the newest one is believed at once.
  static constexpr std::uint64_t reach = std::uint64_t{1} << 16;
  /// While a writer is not heard, this much is added to the reach for each second. No writer publishes more.
  static constexpr std::uint64_t published_per_s_max = std::uint64_t{1} << 22;
  /// A sequence that is more than this behind the newest one needs to be confirmed, too.
  static constexpr std::uint64_t reach_back = std::uint64_t{1} << 26;
  /// After this number of late samples in a row, whose sequences ascend, the numbering begins anew, but not
  /// sooner than after `newest_doubted_after`: what was held up on the way comes all at once.
  static constexpr std::uint32_t late_in_a_row = 64;
  /// Two of them that are that far apart are enough if their stamps are later than that of the newest one,
  /// whatever older ones come between them, or if they are out of its reach: samples that a slow path brings
  /// late are older than the newest one.
  static constexpr std::chrono::milliseconds newest_doubted_after{250};
  /// A repetition of the same sequence confirms it if it comes this much later: the writer sent it twice.
  static constexpr std::chrono::milliseconds repeated_after{10};

  struct Claim {
    std::uint64_t sequence = 0;
    /// The position in the channel of the writer; 0: in none. A sample that is behind in its channel, too, is
    /// a repair.
    std::uint64_t place = 0;
    /// Another number for each datagram, and not 0: one datagram does not confirm itself.
    std::uint64_t datagram = 0;
    std::int64_t stamp_ns = 0;  ///< by the writer's clock
  };
  /// Returns true if a sample that claims this may be delivered.
  bool believes(const Claim& claim, Time now) {
    const bool is_next = newest() != 0 && claim.sequence > newest() && claim.sequence - newest() <= reach;
    if (!is_next) [[unlikely]]
      return judge(claim, now);
    advance(claim, now);
    return true;
  }
  /// Returns the 64-bit sequence for these low bits of it: the one nearest to the newest sequence. If the
  /// bits continue the numbering that lasted longest before, then the one nearest to where that one was.
  std::uint64_t widen(std::uint32_t low) const;

  std::uint64_t newest() const { return newest_.sequence; }
  /// Tells of a numbering that has just begun anew whether everything above it was certainly wrong. If all of
  /// that looked like repairs, it may have been right.
  bool newest_was_wrong() const { return newest_was_wrong_; }
  /// Counts how often the numbering began anew.
  std::uint32_t numbering() const { return numbering_; }

 private:
  bool judge(const Claim& claim, Time now);
  void advance(const Claim& claim, Time now);
  void count_step(const Claim& claim, Time now);
  void begin_anew(const Claim& claim, Time now);
  bool confirmed(const Claim& claim, Time now);
  bool note_late(const Claim& claim, Time now);
  bool note_later(const Claim& claim, Time now);
  bool is_younger(const Claim& claim) const;
  bool note_repair(const Claim& claim, Time now);

  Claim newest_{};  ///< its sequence is 0: none yet
  Time advanced_at_{};
  static constexpr std::uint32_t advances_counted_max = 1000;
  static constexpr std::uint64_t small_step = 64;
  static constexpr std::uint32_t steady_steps = 4;
  std::uint32_t small_steps_ = 0;  ///< in a row, from datagram to datagram
  std::uint64_t steady_ = 0;       ///< the newest one that was reached by small steps in a row
  std::int64_t steady_stamp_ns_ = 0;
  Time steady_at_{};
  std::uint32_t advances_ = 0;  ///< by such steps, since the numbering began anew
  std::uint64_t before_ = 0;    ///< steady_ of the numbering before that lasted longest; 0: there is none
  std::uint32_t before_advances_ = 0;  ///< of that one
  std::uint32_t numbering_ = 0;
  std::uint64_t doubted_ = 0;  ///< a sequence out of reach that waits to be confirmed; 0: none
  std::uint64_t doubted_datagram_ = 0;
  Time doubted_at_{};
  AscendingRow late_;
  AscendingRow later_;    ///< of the late ones those with later stamps, in any order
  AscendingRow repairs_;  ///< datagrams that look like repairs
  std::uint64_t last_late_datagram_ = 0;
  bool newest_was_wrong_ = false;
};

}  // namespace sft::udp
