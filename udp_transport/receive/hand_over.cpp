#include "udp_transport/receive/hand_over.h"

#include <algorithm>
#include <utility>

namespace sft::udp {

namespace {
core::EndpointId writer_of(const HandOver::Waiting& one) { return one.sample->header().writer; }
std::uint64_t sequence_of(const HandOver::Waiting& one) { return one.sample->header().sequence; }
}  // namespace

bool HandOver::concerns(core::EndpointId writer) const {
  return std::ranges::find(waiting_, writer, writer_of) != waiting_.end();
}

/// Adds a sample. If an earlier sample of the same writer waits, the new sample has to wait, too.
void HandOver::add(Waiting one) {
  const auto first = first_of(writer_of(one));
  if (first != waiting_.end() && sequence_of(*first) <= sequence_of(one)) one.overtakes = true;
  waiting_.insert(std::ranges::upper_bound(waiting_, sequence_of(one), {}, sequence_of), std::move(one));
}

HandOver::Waiting HandOver::next(core::EndpointId writer) {
  const auto first = first_of(writer);
  if (first == waiting_.end()) return {};
  const bool follows = last_of_ == writer && sequence_of(*first) <= last_ + 1;
  return !first->overtakes || follows ? take(first) : Waiting{};
}

HandOver::Waiting HandOver::next() { return waiting_.empty() ? Waiting{} : take(waiting_.begin()); }

std::vector<HandOver::Waiting>::iterator HandOver::first_of(core::EndpointId writer) {
  return std::ranges::find(waiting_, writer, writer_of);
}

HandOver::Waiting HandOver::take(std::vector<Waiting>::iterator which) {
  Waiting one = std::move(*which);
  waiting_.erase(which);
  last_of_ = writer_of(one);
  last_ = sequence_of(one);
  return one;
}

}  // namespace sft::udp
