// A maximum rate decides which samples of a writer are for a reader that asks for no more than so many a
// second. Pure: stamps in, answers out.
//
// Time is cut into slots of one period, on the grid of the stamps' clock. Each slot that begins is worth one
// sample, and one that was not used can be saved: a source that beats about as fast as the limit then loses
// nothing to its jitter. So in any n periods at most n + 2 samples pass, and in the long run one in each.
//
// A reader and its writer keep equal limits without talking to each other: whoever begins with as much and
// admits only what the other one admits never has less to spend than the other one. That is how a reader in
// shared memory follows its writer.
#pragma once

#include <cstdint>
#include <limits>

namespace sft::core {

class RateBudget {
 public:
  static constexpr std::int64_t most_saved = 2;

  /// Begins with all that can be saved. A period of 0 us means no limit.
  explicit RateBudget(std::uint32_t min_period_us = 0, std::int64_t saved = most_saved)
      : min_period_us_(min_period_us), saved_(saved) {}
  /// Returns a budget that has nothing to spend before the next slot.
  static RateBudget spent(std::uint32_t min_period_us, std::int64_t stamp_ns);

  std::uint32_t min_period_us() const { return min_period_us_; }
  bool allows(std::int64_t stamp_ns) const;
  /// True if the budget allows a sample, which it has then paid for. Stamps may go back: the clock was set.
  bool take(std::int64_t stamp_ns);
  /// A sample passes whatever the budget says, which pays for it later.
  void spend(std::int64_t stamp_ns);
  /// The number of samples beyond what can be saved that the budget would have allowed until then. Without a
  /// limit it is any number.
  std::uint64_t forfeited(std::int64_t stamp_ns) const;

 private:
  static constexpr std::int64_t never = std::numeric_limits<std::int64_t>::min();
  std::int64_t slot_of(std::int64_t stamp_ns) const;
  std::int64_t worth(std::int64_t stamp_ns) const;

  std::uint32_t min_period_us_;
  std::int64_t slot_ = never;  ///< in which `saved_` was right
  std::int64_t saved_;         ///< less than 0: what is owed
};

}  // namespace sft::core
