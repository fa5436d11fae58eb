// Determines when each contender writes each message. Each contender has a slot of its own in every period.
// So all contenders are measured in the same seconds, and no contender shares the processors with another
// one while its message is under way.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace sft::bench::paper {

struct Pace {
  double rate_hz = 25;  ///< messages per second of each contender
  /// Number of first messages, before all phases, from which SFT learns the needed fields.
  std::size_t learning = 10;
  /// Time between these messages and the first phase, in which discovery and negotiation end.
  double settled_s = 3;
  std::size_t settling = 25;  ///< number of messages at the start of each phase that are not counted
  std::size_t samples = 50;   ///< number of messages of each phase that are counted
};

/// Returns an error text if the contenders' slots would be too short; otherwise an empty text.
std::string check(const Pace& pace, std::size_t contenders);

/// The schedule of a session. All times are nanoseconds of CLOCK_MONOTONIC.
class Schedule {
 public:
  Schedule(const Pace& pace, std::size_t contenders, std::int64_t begin_ns)
      : pace_(pace), contenders_(contenders), begin_ns_(begin_ns) {}

  /// Returns when a contender with this slot writes the `number`-th of the messages from which SFT learns
  /// the fields.
  std::int64_t learning_ns(std::size_t number, std::size_t slot) const;
  /// Returns when a contender with this slot writes its `number`-th message of a phase. The messages that
  /// are counted begin with number Pace::settling.
  std::int64_t due_ns(std::size_t phase, std::size_t number, std::size_t slot) const;
  /// Returns the minimum pause of a late contender after each message. Because of it, the number of an
  /// arriving message is known.
  std::int64_t pause_min_ns() const { return period_ns() / 2; }
  /// Returns the largest delay of a message that is still counted in its phase.
  static std::int64_t late_max_ns() { return gap_ns / 4; }
  /// Return times at which no message is under way, before and after the messages of a phase that are
  /// counted.
  std::int64_t before_ns(std::size_t phase) const;
  std::int64_t after_ns(std::size_t phase) const;

 private:
  static constexpr std::int64_t gap_ns = 200'000'000;

  std::int64_t slot_ns(std::size_t slot) const;
  std::int64_t period_ns() const { return static_cast<std::int64_t>(1e9 / pace_.rate_hz); }
  std::int64_t begin_ns(std::size_t phase) const;

  const Pace pace_;
  const std::size_t contenders_;
  const std::int64_t begin_ns_;
};

}  // namespace sft::bench::paper
