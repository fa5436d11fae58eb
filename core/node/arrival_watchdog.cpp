#include "core/node/arrival_watchdog.h"

#include <algorithm>
#include <utility>

namespace sft::core {

void ArrivalWatchdog::excuse() {
  signs_.reset();
  base_.reset();
  missed_since_.reset();
}

bool ArrivalWatchdog::needs_progress(Time now) {
  if (signs_ && now - arrived_at_ >= quiet_after) needs_progress_until_ = now + progress_needed_for;
  return now < needs_progress_until_;
}

bool ArrivalWatchdog::look(const Progress* progress, std::uint64_t signs, const Pair& pair, Time now) {
  const Time before = std::exchange(looked_at_, now);
  if (before != Time{} && now - before >= stopped_after) {
    excuse();
    reports_count_from_ = now + report_age_max;  // older reports may have waited for the process
  }
  if (signs_ != signs) {
    if (signs_) {  // the connection works
      pause_ = {};
      reports_count_from_ = now + report_age_max;
    }
    excuse();
    signs_ = signs;
    arrived_at_ = now;
  }
  if (progress != nullptr && now >= reports_count_from_) advance(*progress, pair, now);
  if (!base_) return false;
  if (!missed_since_ && is_missed(pair)) missed_since_ = now;
  if (!missed_since_ || now - *missed_since_ < time_to_arrive(pair) || now < next_) return false;
  excuse();  // a new connection counts its arrivals from 0
  ++restarts_;
  pause_ = std::clamp<std::chrono::nanoseconds>(pause_ * 2, pause_first, pause_longest);
  next_ = now + pause_;
  return true;
}

void ArrivalWatchdog::advance(const Progress& progress, const Pair& pair, Time now) {
  if (!base_ || progress.samples < base_->samples) {
    base_ = latest_ = progress;
    periods_ = 0;
    period_at_ = now;
    missed_since_.reset();
    return;
  }
  if (progress.samples > latest_.samples &&
      now - period_at_ >= std::chrono::microseconds(pair.min_period_us)) {
    ++periods_;
    period_at_ = now;
  }
  latest_ = progress;
}

/// Returns true if the number of samples sent is so large that a working connection cannot have lost all of
/// these samples.
bool ArrivalWatchdog::is_missed(const Pair& pair) const {
  const std::uint64_t enough = pair.reliable ? missing_where_reliable : missing_where_lossy;
  const bool was_let_through = pair.min_period_us == 0 || periods_ >= enough;
  return latest_.samples - base_->samples >= enough && was_let_through;
}

std::chrono::nanoseconds ArrivalWatchdog::time_to_arrive(const Pair& pair) const {
  const std::uint64_t samples = std::max<std::uint64_t>(latest_.samples - base_->samples, 1);
  const std::uint64_t bytes = latest_.bytes > base_->bytes ? latest_.bytes - base_->bytes : 0;
  const std::chrono::microseconds on_the_way(bytes / samples * 1'000'000 / slowest_bytes_per_s);
  const std::chrono::seconds least = pair.awaits_history ? timeout_with_history : timeout;
  return least + on_the_way + 2 * std::chrono::microseconds(pair.min_period_us);
}

}  // namespace sft::core
