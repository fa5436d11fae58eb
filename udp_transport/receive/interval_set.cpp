#include "udp_transport/receive/interval_set.h"

#include <algorithm>

namespace sft::udp {

std::uint32_t IntervalSet::add(std::uint32_t begin, std::uint32_t end) {
  if (!intervals_.empty() && intervals_.back().end == begin) {  // the new interval continues the last one
    intervals_.back().end = end;
    covered_ += end - begin;
    return end - begin;
  }
  // All intervals in [first, last) overlap or touch the new one, and are merged with it.
  const auto first = std::lower_bound(intervals_.begin(), intervals_.end(), begin,
                                      [](const Interval& i, std::uint32_t value) { return i.end < value; });
  auto last = first;
  Interval merged{begin, end};
  std::uint32_t had = 0;
  for (; last != intervals_.end() && last->begin <= end; ++last) {
    merged = {std::min(merged.begin, last->begin), std::max(merged.end, last->end)};
    had += last->end - last->begin;
  }
  if (first == last) {
    intervals_.insert(first, merged);
  } else {
    *first = merged;
    intervals_.erase(first + 1, last);
  }
  const std::uint32_t added = merged.end - merged.begin - had;
  covered_ += added;
  return added;
}

bool IntervalSet::stands_alone(std::uint32_t begin, std::uint32_t end) const {
  const auto next = std::lower_bound(intervals_.begin(), intervals_.end(), begin,
                                     [](const Interval& i, std::uint32_t value) { return i.end < value; });
  return next == intervals_.end() || next->begin > end;
}

}  // namespace sft::udp
