#include "core/seam/rate_budget.h"

#include <algorithm>

namespace sft::core {

RateBudget RateBudget::spent(std::uint32_t min_period_us, std::int64_t stamp_ns) {
  RateBudget budget(min_period_us, 0);
  if (min_period_us != 0) budget.slot_ = budget.slot_of(stamp_ns);
  return budget;
}

/// Returns the number of the slot of a stamp, rounded down, also for negative stamps.
std::int64_t RateBudget::slot_of(std::int64_t stamp_ns) const {
  const std::int64_t period_ns = std::int64_t{min_period_us_} * 1000;
  return stamp_ns / period_ns - (stamp_ns % period_ns < 0 ? 1 : 0);
}

/// Returns the number of samples that would be saved at the time of the stamp if the number of saved
/// samples were not bounded.
std::int64_t RateBudget::worth(std::int64_t stamp_ns) const {
  if (slot_ == never) return saved_;
  return saved_ + std::max<std::int64_t>(0, slot_of(stamp_ns) - slot_);
}

bool RateBudget::allows(std::int64_t stamp_ns) const { return min_period_us_ == 0 || worth(stamp_ns) > 0; }

bool RateBudget::take(std::int64_t stamp_ns) {
  if (min_period_us_ == 0) return true;
  saved_ = std::min(worth(stamp_ns), most_saved);
  slot_ = slot_of(stamp_ns);
  if (saved_ <= 0) return false;
  --saved_;
  return true;
}

void RateBudget::spend(std::int64_t stamp_ns) {
  if (min_period_us_ == 0) return;
  saved_ = std::min(worth(stamp_ns), most_saved) - 1;
  slot_ = slot_of(stamp_ns);
}

std::uint64_t RateBudget::forfeited(std::int64_t stamp_ns) const {
  if (min_period_us_ == 0) return std::numeric_limits<std::uint64_t>::max();
  return static_cast<std::uint64_t>(std::max<std::int64_t>(0, worth(stamp_ns) - most_saved));
}

}  // namespace sft::core
