#include "tools/perf/sequence.h"

#include <algorithm>
#include <utility>

namespace sft::perf {

void Answered::note(std::uint64_t sample) {
  ++count_;
  if (sample != expected_) parts_.push_back({count_, sample});
  expected_ = sample + 1;
}

std::vector<Part> Answered::take_parts() { return std::exchange(parts_, {}); }

std::uint64_t sample_of(std::uint64_t answer, const std::vector<Part>& parts) {
  const auto after = std::ranges::upper_bound(parts, answer, {}, &Part::answer);
  if (after == parts.begin()) return 0;
  const Part& part = *std::prev(after);
  return part.sample + (answer - part.answer);
}

bool Tally::note(std::uint64_t number) {
  if (number >= came_.size()) came_.resize(std::max<std::size_t>(number + 1, 2 * came_.size()));
  if (came_[number]) {
    ++twice_;
    return false;
  }
  came_[number] = true;
  ++distinct_;
  if (number < highest_) ++reordered_;
  highest_ = std::max(highest_, number);
  return true;
}

std::int64_t counted_from(std::int64_t due_ns, std::int64_t sent_ns, std::int64_t period_ns, bool& is_late) {
  constexpr std::int64_t usual_ns = 1'000'000;  // the usual time for a thread to wake up
  is_late = sent_ns - due_ns > std::min(period_ns, usual_ns);
  return is_late ? due_ns : sent_ns;
}

}  // namespace sft::perf
