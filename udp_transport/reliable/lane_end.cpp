#include "udp_transport/reliable/lane_end.h"

#include <algorithm>

namespace sft::udp {

bool LaneEnd::meets_merged(const LaneEnd& other) const {
  if (!is_merged() && !other.is_merged()) return false;
  // These references keep the listeners alive while their receivers are used.
  const std::shared_ptr<LaneListener> group = group_.lock(), other_group = other.group_.lock();
  const Destination* const alone = to_.get();
  const Destination* const other_alone = other.to_.get();
  const std::span receivers = group ? group->receivers() : std::span(&alone, 1);
  const std::span others = other_group ? other_group->receivers() : std::span(&other_alone, 1);
  return std::ranges::find_first_of(receivers, others) != receivers.end();
}

void LaneEnd::departed(const JobHandle& job, bool lost) const {
  if (const std::shared_ptr<LaneListener> group = group_.lock(); group && job) group->departed(*job, lost);
}

}  // namespace sft::udp
