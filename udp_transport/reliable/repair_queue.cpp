#include "udp_transport/reliable/repair_queue.h"

#include <algorithm>

namespace sft::udp {

namespace {
constexpr std::size_t burst_bytes = std::size_t{1} << 20;

std::size_t bytes_of(const BodyRange& range) { return range.end - range.begin; }

bool overlap(const RepairQueue::Repair& a, const RepairQueue::Repair& b) {
  if (a.ordinal != b.ordinal) return false;
  return a.range == b.range || (a.range.begin < b.range.end && b.range.begin < a.range.end);
}
}  // namespace

RepairQueue::RepairQueue(std::uint64_t bytes_per_s) : pacer_(bytes_per_s, burst_bytes) {
  waiting_.reserve(repairs_max);
}

void RepairQueue::ask_for(const Repair& repair) {
  const BodyRange& range = repair.range;
  if (range.begin > range.end || waiting_.size() >= repairs_max) return;
  if (range.begin != 0 && range.begin == range.end) return;
  const auto is_known = [&](const Repair& known) { return overlap(known, repair); };
  if (std::ranges::any_of(waiting_, is_known)) return;
  if (std::ranges::any_of(sent_lately_, is_known, &Sent::repair)) return;
  waiting_.push_back(repair);
}

void RepairQueue::forget_sent_before(Time time) {
  while (!sent_lately_.empty() && sent_lately_.front().at <= time) sent_lately_.pop_front();
}

void RepairQueue::drop_before(std::uint64_t ordinal) {
  std::erase_if(waiting_, [&](const Repair& repair) { return repair.ordinal < ordinal; });
}

std::optional<RepairQueue::Repair> RepairQueue::next(Size size, Time now) {
  is_paced_ = false;
  const auto found = std::ranges::find_if(
      waiting_, [&](const Repair& repair) { return KeptSamples::size_of(bytes_of(repair.range)) == size; });
  if (found == waiting_.end()) return {};
  is_paced_ = !pacer_.ready(now);
  if (is_paced_) return {};
  const Repair repair = *found;
  pacer_.spend(std::max<std::size_t>(bytes_of(repair.range), datagram_bytes_min));
  if (sent_lately_.size() == repairs_max) sent_lately_.pop_front();
  sent_lately_.push_back({repair, now});
  waiting_.erase(found);
  ++sent_;
  return repair;
}

}  // namespace sft::udp
