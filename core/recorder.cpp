#include "core/recorder.h"

#include <bit>
#include <utility>

namespace sft::core {

std::shared_ptr<Recorder> Recorder::make(std::size_t leaves, const RecordingSettings& settings,
                                         Changed changed) {
  return std::shared_ptr<Recorder>(new Recorder(leaves, settings, std::move(changed)));
}

Recorder::Recorder(std::size_t leaves, const RecordingSettings& settings, Changed changed)
    : settings_(settings),
      changed_(std::move(changed)),
      required_(FieldMask::full(leaves)),
      last_read_(leaves, 0),
      counts_(leaves, 0) {}

void Recorder::detach() {
  const std::scoped_lock lock(mutex_);
  changed_ = nullptr;
}

RecordedSample* Recorder::begin() {
  RecordedSample* sample = nullptr;
  {
    const std::scoped_lock lock(mutex_);
    if (free_.empty()) {
      AccessLog::MissListener* const listener = this;
      owned_.push_back(std::make_unique<RecordedSample>(required_.words(), listener));
      free_.reserve(owned_.size());  // so that end() allocates nothing
      free_.push_back(owned_.back().get());
    }
    sample = free_.back();
    free_.pop_back();
  }
  sample->recorder_ = shared_from_this();
  return sample;
}

void Recorder::end(RecordedSample* sample) noexcept {
  const std::shared_ptr<Recorder> recorder = std::move(sample->recorder_);
  recorder->fold(*sample);
}

void Recorder::fold(RecordedSample& sample) noexcept {
  const std::scoped_lock lock(mutex_);
  ++samples_;
  for (std::size_t i = 0; i < sample.words_.size(); ++i) {
    for (std::uint64_t bits = sample.words_[i].exchange(0, std::memory_order_relaxed); bits != 0;
         bits &= bits - 1) {
      const std::size_t leaf = i * 64 + static_cast<std::size_t>(std::countr_zero(bits));
      last_read_[leaf] = samples_;
      ++counts_[leaf];
    }
  }
  free_.push_back(&sample);
  if (refresh_required() && changed_) changed_();
}

/// With the mutex held: whether required_ is another one now. A leaf is needed if it was read lately; where
/// one was never read, that is known once the first samples are through.
bool Recorder::refresh_required() {
  if (samples_ < settings_.learn_samples) return false;
  bool changed = false;
  for (std::size_t leaf = 0; leaf < last_read_.size(); ++leaf) {
    const bool needed = last_read_[leaf] != 0 && samples_ < last_read_[leaf] + settings_.narrow_after_samples;
    if (needed == required_.contains(leaf)) continue;
    needed ? required_.insert(leaf) : required_.erase(leaf);
    changed = true;
  }
  return changed;
}

void Recorder::missed(std::size_t leaf) noexcept {
  const std::scoped_lock lock(mutex_);
  if (required_.contains(leaf)) return;  // asked for already, the samples that have it are under way
  required_.insert(leaf);
  last_read_[leaf] = samples_ + 1;  // the sample being read
  if (changed_) changed_();
}

FieldMask Recorder::required() const {
  const std::scoped_lock lock(mutex_);
  return required_;
}

std::vector<std::uint64_t> Recorder::counts() const {
  const std::scoped_lock lock(mutex_);
  return counts_;
}

}  // namespace sft::core
