#include "udp_transport/receive/keep_last_queue.h"

#include <algorithm>
#include <utility>

namespace sft::udp {

KeepLastQueue::Put KeepLastQueue::put(core::SampleHandle& sample, std::uint64_t arrival) {
  const std::uint64_t number = sample->header().sequence;
  if (sample->numbering > numbering_) begin_anew(*sample);
  if (number <= gone_) return Put::late;
  std::size_t place = size_;
  while (place > 0 && sequence(place - 1) > number) --place;
  if (place > 0 && sequence(place - 1) == number) return Put::repeated;

  core::SampleHandle oldest;
  if (size_ == depth_) {
    if (place == 0) {
      gone_ = number;
      return Put::late;
    }
    oldest = pop();
    --place;
  }
  if (size_ == entries_.size()) grow();
  for (std::size_t i = size_; i > place; --i) at(i) = std::move(at(i - 1));
  at(place) = {std::move(sample), arrival};
  ++size_;
  sample = std::move(oldest);
  return sample ? Put::pushed_out : Put::kept;
}

/// Sequences that are not below the sample's were wrong.
void KeepLastQueue::begin_anew(const core::SampleBuffer& sample) {
  const std::uint64_t number = sample.header().sequence;
  numbering_ = sample.numbering;
  gone_ = std::min(gone_, number - 1);
  while (size_ > 0 && sequence(size_ - 1) >= number) {
    at(--size_).sample.reset();
    ++dropped_;
  }
}

core::SampleHandle KeepLastQueue::pop() {
  core::SampleHandle sample = std::move(entries_[head_].sample);
  gone_ = sample->header().sequence;
  head_ = (head_ + 1) % entries_.size();
  --size_;
  return sample;
}

void KeepLastQueue::grow() {
  std::vector<Entry> larger(std::max<std::size_t>(4, 2 * entries_.size()));
  for (std::size_t i = 0; i < size_; ++i) larger[i] = std::move(at(i));
  entries_ = std::move(larger);
  head_ = 0;
}

}  // namespace sft::udp
