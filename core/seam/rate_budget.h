// Decides which samples of a writer are for a reader that requests a maximum rate. It uses no clock: stamps
// are passed in, decisions are returned.
//
// Time is divided into slots of one period, on the grid of the stamps' clock. At the beginning of each slot
// the budget grows by one sample; of unused samples, one can be saved. So a source whose rate is about the
// limit loses no samples by its jitter. In any n periods at most n + 2 samples pass, and in the long run
// one per period.
//
// A reader and its writer keep equal limits without any messages: a side that begins with the same budget,
// and admits only samples that the other side has admitted, never has less budget than that side. Thus a
// reader in shared memory admits whatever its writer admits.
#pragma once

#include <cstdint>
#include <limits>

namespace sft::core {

class RateBudget {
 public:
  static constexpr std::int64_t most_saved = 2;

  /// By default the budget begins with the maximum number of samples that can be saved. A period of 0 us
  /// means no limit.
  explicit RateBudget(std::uint32_t min_period_us = 0, std::int64_t saved = most_saved)
      : min_period_us_(min_period_us), saved_(saved) {}
  /// Returns a budget that allows no sample before the next slot.
  static RateBudget spent(std::uint32_t min_period_us, std::int64_t stamp_ns);

  std::uint32_t min_period_us() const { return min_period_us_; }
  bool allows(std::int64_t stamp_ns) const;
  /// Returns true if the budget allows a sample, and subtracts it from the budget. Stamps may go back if the
  /// clock was set.
  bool take(std::int64_t stamp_ns);
  /// Subtracts a sample that passes even if the budget does not allow it. The budget may become negative.
  void spend(std::int64_t stamp_ns);
  /// Returns the number of samples that the budget would have allowed by the time of the stamp, without
  /// those that can be saved. Returns the greatest value of the type if there is no limit.
  std::uint64_t forfeited(std::int64_t stamp_ns) const;

 private:
  static constexpr std::int64_t never = std::numeric_limits<std::int64_t>::min();
  std::int64_t slot_of(std::int64_t stamp_ns) const;
  std::int64_t worth(std::int64_t stamp_ns) const;

  std::uint32_t min_period_us_;
  std::int64_t slot_ = never;  ///< the slot for which `saved_` is valid
  std::int64_t saved_;  ///< the number of samples that are allowed; negative: samples that passed in advance
};

}  // namespace sft::core
