#include "core/subscribe/recorder.h"

#include <bit>
#include <utility>

namespace sft::core {

namespace {

constexpr std::uint64_t bit(std::size_t leaf) { return std::uint64_t{1} << (leaf % 64); }

/// Returns and clears the bits of one word of accesses. Must be called when the sample is no longer read.
std::uint64_t take_bits(detail::AccessWord& word) noexcept {
  const std::uint64_t bits =
      word.found.load(std::memory_order_relaxed) | word.missed.load(std::memory_order_relaxed);
  if (bits == 0) return 0;
  word.found.store(0, std::memory_order_relaxed);
  word.missed.store(0, std::memory_order_relaxed);
  return bits;
}

}  // namespace

Result<void> Recorder::check(const SubscriberOptions::Recording& settings) {
  if (settings.learn_samples == 0) {
    return fail(Errc::invalid_argument,
                "recording.learn_samples is 0: what is needed is learnt from at least one sample");
  }
  return {};
}

std::shared_ptr<Recorder> Recorder::make(std::size_t leaves, const SubscriberOptions::Recording& settings,
                                         Changed changed, std::vector<ChannelNumbers::Cloud> clouds) {
  return std::shared_ptr<Recorder>(new Recorder(leaves, settings, std::move(changed), std::move(clouds)));
}

Recorder::Recorder(std::size_t leaves, const SubscriberOptions::Recording& settings, Changed changed,
                   std::vector<ChannelNumbers::Cloud> clouds)
    : leaf_count_(leaves),
      settings_(settings),
      channels_(leaves, std::move(clouds)),
      changed_(std::move(changed)),
      required_(FieldMask(channels_.numbers()).words()),
      leaves_(channels_.numbers()),
      order_(channels_.numbers()) {
  const FieldMask all = FieldMask::full(leaves);
  for (std::size_t i = 0; i < all.words(); ++i) required_[i].store(all.word(i));
}

RecordedSample* Recorder::begin() {
  RecordedSample* sample = nullptr;
  {
    const Lock lock(mutex_);
    if (free_ != nullptr) sample = std::exchange(free_, free_->next_free_);
  }
  if (sample == nullptr) sample = add();
  sample->recorder_ = shared_from_this();
  return sample;
}

/// Adds an object for a sample, since all existing objects are in use.
RecordedSample* Recorder::add() {
  detail::AccessLog::Listener* const listener = this;
  auto added = std::make_unique<RecordedSample>(required_.size(), listener);
  const Lock lock(mutex_);
  return owned_.emplace_back(std::move(added)).get();
}

void Recorder::end(RecordedSample* sample) noexcept {
  const std::shared_ptr<Recorder> recorder = std::move(sample->recorder_);
  recorder->fold(*sample);
}

void Recorder::fold(RecordedSample& sample) noexcept {
  bool changed = false;
  {
    const Lock lock(mutex_);
    ++samples_;
    changed = count(sample);
    changed |= give_up_stale();
    changed |= samples_ == settings_.learn_samples && finish_learning();
    sample.set_channels_sent(nullptr);
    sample.next_free_ = std::exchange(free_, &sample);
  }
  if (changed) changed_();
}

bool Recorder::count(RecordedSample& sample) noexcept {
  bool changed = false;
  for (std::size_t i = 0; i < sample.words_.size(); ++i) {
    for (std::uint64_t bits = take_bits(sample.words_[i]); bits != 0; bits &= bits - 1) {
      const std::size_t leaf = i * 64 + static_cast<std::size_t>(std::countr_zero(bits));
      leaves_[leaf].was_read = true;
      count_use(leaf);
      changed |= need(leaf, samples_);
    }
  }
  return changed;
}

/// Counts a leaf as read in the present sample, at most once. The reading of a channel also counts for all
/// fields that describe its position.
void Recorder::count_use(std::size_t leaf) noexcept {
  if (leaf >= leaf_count_) {
    for (const std::size_t field : channels_.fields_of(leaf)) count_use(field);
    return;
  }
  LeafUse& use = leaves_[leaf].use;
  if (use.last_sample == samples_) return;
  ++use.samples;
  use.last_sample = samples_;
}

bool Recorder::need(std::size_t leaf, std::uint64_t sample) noexcept {
  leaves_[leaf].needed_since = sample;
  order_.was_read(leaf);
  if (is_required(leaf)) return false;
  required_[leaf / 64].fetch_or(bit(leaf), std::memory_order_relaxed);
  return true;
}

/// Stops requiring leaves that were not read for too long. They are at the front of the order.
bool Recorder::give_up_stale() noexcept {
  if (settings_.narrow_after_samples == 0) return false;
  const bool learnt = samples_ >= settings_.learn_samples;
  bool changed = false;
  while (!order_.empty()) {
    const std::size_t leaf = order_.oldest();
    if (samples_ < leaves_[leaf].needed_since + settings_.narrow_after_samples) break;
    order_.remove(leaf);
    if (learnt) required_[leaf / 64].fetch_and(~bit(leaf), std::memory_order_relaxed);
    changed |= learnt;
  }
  return changed;
}

/// Ends the learning phase. Fields that were not read are no longer required.
bool Recorder::finish_learning() noexcept {
  bool changed = false;
  for (std::size_t leaf = 0; leaf < leaves_.size(); ++leaf) {
    if (order_.contains(leaf)) continue;
    required_[leaf / 64].fetch_and(~bit(leaf), std::memory_order_relaxed);
    changed = true;
  }
  return changed;
}

bool Recorder::is_required(std::size_t leaf) const noexcept {
  return (required_[leaf / 64].load(std::memory_order_relaxed) & bit(leaf)) != 0;
}

void Recorder::first_read(std::size_t leaf) noexcept {
  if (is_required(leaf)) return;
  {
    const Lock lock(mutex_);
    // The number of the sample that is being read will be at least this.
    if (!need(leaf, samples_ + 1)) return;
  }
  changed_();
}

Selection Recorder::required() const {
  std::vector<std::uint64_t> words(required_.size());
  {
    const Lock lock(mutex_);
    for (std::size_t i = 0; i < words.size(); ++i) words[i] = required_[i].load(std::memory_order_relaxed);
  }
  return channels_.selection(FieldMask::from_words(channels_.numbers(), words));
}

Recorder::Use Recorder::use() const {
  Use use{.samples = 0, .leaves = std::vector<LeafUse>(leaf_count_), .read = {}};
  FieldMask read(channels_.numbers());
  {
    const Lock lock(mutex_);
    use.samples = samples_;
    for (std::size_t leaf = 0; leaf < leaf_count_; ++leaf) use.leaves[leaf] = leaves_[leaf].use;
    for (std::size_t number = 0; number < leaves_.size(); ++number) {
      if (leaves_[number].was_read) read.insert(number);
    }
  }
  use.read = channels_.selection(read);
  return use;
}

}  // namespace sft::core
