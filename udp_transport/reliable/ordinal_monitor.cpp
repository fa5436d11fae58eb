#include "udp_transport/reliable/ordinal_monitor.h"

#include <algorithm>

namespace sft::udp {

void OrdinalMonitor::came(std::uint64_t ordinal) {
  if (ordinal >= came_end_) {
    if (ordinal - came_end_ >= remembered) came_.reset();
    for (std::uint64_t i = came_end_; i < ordinal && ordinal - came_end_ < remembered; ++i)
      came_.reset(i % remembered);
    came_end_ = ordinal + 1;
  } else if (came_end_ - ordinal > remembered) {
    return;
  }
  came_.set(ordinal % remembered);
}

bool OrdinalMonitor::has_come(std::uint64_t ordinal) const {
  return ordinal < came_end_ && came_end_ - ordinal <= remembered && came_.test(ordinal % remembered);
}

std::optional<std::uint64_t> OrdinalMonitor::passed_over(std::uint64_t ordinal, bool same_datagram,
                                                         Time now) {
  if (has_come(ordinal) || (same_datagram && passed_over_ > 0)) return {};
  const bool ascends = passed_over_ > 0 && ordinal >= last_passed_over_;
  const bool was_overtaken = passed_over_ > 0 && !ascends && ordinal >= first_passed_over_ &&
                             last_passed_over_ - ordinal < passed_over_in_a_row;
  if (was_overtaken) return {};
  if (!ascends) {
    first_passed_over_ = ordinal;
    passed_over_since_ = now;
  }
  samples_passed_over_ = !ascends ? 1 : samples_passed_over_ + (ordinal != last_passed_over_ ? 1 : 0);
  passed_over_ = ascends ? passed_over_ + 1 : 1;
  last_passed_over_ = ordinal;
  const bool nothing_new = now - passed_over_since_ >= unconfirmed_after;
  if (samples_passed_over_ < passed_over_in_a_row && (passed_over_ < unconfirmed_by || !nothing_new))
    return {};
  return first_passed_over_;
}

bool OrdinalMonitor::confirmed(std::uint64_t ordinal, bool same_datagram, Time now) {
  const std::uint64_t apart = std::max(ordinal, unconfirmed_) - std::min(ordinal, unconfirmed_);
  const bool is_other = apart != 0 || now - unconfirmed_at_ >= repeated_after;
  if (unconfirmed_ != 0 && !same_datagram && apart <= remembered && is_other) return true;
  if (apart != 0) unconfirmed_at_ = now;
  unconfirmed_ = ordinal;
  return false;
}

void OrdinalMonitor::go_on_with(std::uint64_t ordinal) {
  if (came_end_ > ordinal + remembered) {
    came_.reset();
    came_end_ = 0;
  }
  advanced();
}

}  // namespace sft::udp
