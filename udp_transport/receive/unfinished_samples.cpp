#include "udp_transport/receive/unfinished_samples.h"

#include <algorithm>
#include <utility>

namespace sft::udp {

/// Returns the sample with that label. Searches the samples that are in no channel from the end, because the
/// datagram most likely belongs to a new sample.
UnfinishedSample* UnfinishedSamples::search(const SampleLabel& label) const {
  if (last_found_ != nullptr && last_found_->label() == label) return last_found_;
  const auto loose = std::find_if(loose_.rbegin(), loose_.rend(),
                                  [&](const Handle& sample) { return sample->label() == label; });
  if (loose != loose_.rend()) return last_found_ = loose->get();
  UnfinishedSample* sample = bucket_of(label);
  while (sample != nullptr && sample->label() != label) sample = sample->next_in_bucket_;
  if (sample != nullptr) last_found_ = sample;
  return sample;
}

UnfinishedSample& UnfinishedSamples::add(Handle sample) {
  UnfinishedSample& added = *sample;
  if (added.place() == 0) {
    loose_.push_back(std::move(sample));
  } else {
    place(std::move(sample));
  }
  return added;
}

UnfinishedSamples::Handle UnfinishedSamples::remove(const SampleLabel& label) {
  UnfinishedSample* const sample = find(label);
  last_found_ = nullptr;
  if (sample == nullptr) return nullptr;
  return sample->place() == 0 ? take_loose(label) : take_placed(*sample);
}

void UnfinishedSamples::set_place(UnfinishedSample& sample, std::uint64_t place) {
  const bool moves = (sample.place() == 0) != (place == 0);
  if (!moves) return sample.set_place(place);
  Handle moved = sample.place() == 0 ? take_loose(SampleLabel(sample.label())) : take_placed(sample);
  moved->set_place(place);
  add(std::move(moved));
}

void UnfinishedSamples::forget_places() {
  for (Handle& sample : placed_) {
    sample->set_place(0);
    sample->next_in_bucket_ = nullptr;
    loose_.push_back(std::move(sample));
  }
  placed_.clear();
  std::ranges::fill(buckets_, nullptr);
}

void UnfinishedSamples::place(Handle sample) {
  sample->index_ = placed_.size();
  placed_.push_back(std::move(sample));
  if (placed_.size() <= buckets_.size()) return insert(*placed_.back());
  buckets_.assign(2 * buckets_.size(), nullptr);
  for (const Handle& known : placed_) insert(*known);
}

void UnfinishedSamples::insert(UnfinishedSample& sample) {
  UnfinishedSample*& bucket = bucket_of(sample.label());
  sample.next_in_bucket_ = std::exchange(bucket, &sample);
}

UnfinishedSamples::Handle UnfinishedSamples::take_loose(const SampleLabel& label) {
  const auto found = std::ranges::find_if(loose_, [&](const Handle& s) { return s->label() == label; });
  Handle taken = std::move(*found);
  loose_.erase(found);
  return taken;
}

UnfinishedSamples::Handle UnfinishedSamples::take_placed(UnfinishedSample& sample) {
  UnfinishedSample** link = &bucket_of(sample.label());
  while (*link != &sample) link = &(*link)->next_in_bucket_;
  *link = std::exchange(sample.next_in_bucket_, nullptr);
  const std::size_t index = sample.index_;
  Handle taken = std::move(placed_[index]);
  if (index + 1 < placed_.size()) {
    placed_[index] = std::move(placed_.back());
    placed_[index]->index_ = index;
  }
  placed_.pop_back();
  return taken;
}

}  // namespace sft::udp
