#include "udp_transport/reliable/repair_schedule.h"

#include <algorithm>
#include <utility>

namespace sft::udp {

RepairSchedule::Time RepairSchedule::ask(Entry& entry, Time now) const {
  const auto pause = delay_ * (2 << std::min<int>(entry.asked, 8));
  entry.ask_at = now + std::min<Time::duration>(pause, limits_.ask_again_longest);
  entry.asked_at = now;
  entry.parts = 1;
  if (entry.asked < UINT8_MAX) ++entry.asked;
  return entry.ask_at;
}

void RepairSchedule::came_again(Entry& entry) {
  if (entry.parts == 0 || --entry.parts > 0) return;
  delay_ = std::min<Time::duration>(2 * delay_, delay_longest);
}

void RepairSchedule::came_whole(const Entry& entry) {
  if (entry.parts > 0)  // the sample was requested, and not all of its parts came twice
    delay_ = std::max<Time::duration>(limits_.ask_after, delay_ - delay_ / 8);
}

bool RepairSchedule::is_stuck(std::uint64_t next, Time first_came, Time now) {
  if (std::exchange(first_missing_, next) != next) first_missing_since_ = now;
  const Time since = std::max(first_missing_since_, first_came);
  return now - since >= limits_.confirm_timeout && heard_at_ - since >= limits_.confirm_timeout / 2;
}

}  // namespace sft::udp
