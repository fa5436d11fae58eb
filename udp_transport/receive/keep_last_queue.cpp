#include "udp_transport/receive/keep_last_queue.h"

#include <algorithm>
#include <limits>
#include <utility>

namespace sft::udp {

KeepLastQueue::Put KeepLastQueue::put(core::SampleHandle& sample, std::uint64_t arrival, Excess excess) {
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
  bytes_ += bytes_of(place);
  if (excess == Excess::pushed_out) {
    if (core::SampleHandle dropped = drop_excess_bytes()) {
      dropped_ += oldest ? 1 : 0;
      oldest = std::move(dropped);
    }
  }
  sample = std::move(oldest);
  return sample ? Put::pushed_out : Put::kept;
}

/// Drops the oldest samples until the bytes are within the limit. Returns one of the dropped samples; the
/// others are counted in `dropped_`.
core::SampleHandle KeepLastQueue::drop_excess_bytes() {
  core::SampleHandle dropped;
  while (bytes_max_ != 0 && bytes_ > bytes_max_ && size_ > 1) {
    dropped_ += dropped ? 1 : 0;
    dropped = pop();
  }
  return dropped;
}

KeepLastQueue::Room KeepLastQueue::room() const {
  const std::uint64_t limit = bytes_max_ == 0 ? std::numeric_limits<std::uint64_t>::max() : bytes_max_;
  return {depth_ - size_, limit - std::min(limit, bytes_), size_ == 0};
}

bool KeepLastQueue::Room::take(std::uint64_t bytes) {
  if (samples_ == 0 || (bytes > bytes_ && !is_empty_)) return false;
  --samples_;
  bytes_ -= std::min(bytes_, bytes);
  is_empty_ = false;
  return true;
}

/// Begins a new numbering with this sample. Drops the samples with this sequence or a greater one, because
/// their sequences were wrong.
void KeepLastQueue::begin_anew(const core::SampleBuffer& sample) {
  const std::uint64_t number = sample.header().sequence;
  numbering_ = sample.numbering;
  gone_ = std::min(gone_, number - 1);
  while (size_ > 0 && sequence(size_ - 1) >= number) {
    bytes_ -= bytes_of(size_ - 1);
    at(--size_).sample.reset();
    ++dropped_;
  }
}

core::SampleHandle KeepLastQueue::pop() {
  core::SampleHandle sample = std::move(entries_[head_].sample);
  gone_ = sample->header().sequence;
  bytes_ -= sample->header().body_bytes;
  head_ = (head_ + 1) % entries_.size();
  --size_;
  if (size_ == 0 && entries_.size() > kept_entries_max) entries_ = std::vector<Entry>();
  return sample;
}

void KeepLastQueue::grow() {
  std::vector<Entry> larger(std::max<std::size_t>(4, 2 * entries_.size()));
  for (std::size_t i = 0; i < size_; ++i) larger[i] = std::move(at(i));
  entries_ = std::move(larger);
  head_ = 0;
}

}  // namespace sft::udp
