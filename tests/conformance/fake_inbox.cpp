#include "tests/conformance/fake_inbox.h"

#include <algorithm>
#include <utility>

namespace sft::test {

using core::EndpointId;
using core::HistoryProgress;
using core::SampleBuffer;
using core::SampleHandle;

FakeInbox::FakeInbox(const core::ReaderSpec& spec)
    : id_(spec.id), depth_(std::max(spec.depth, 1U)), notify_listener_([listener = spec.listener] {
        if (listener != nullptr) listener->arrived();
      }) {}

bool FakeInbox::put(SampleHandle sample) {
  std::vector<SampleHandle> surplus;  // destroyed after the lock of the mutex is released
  const std::scoped_lock lock(mutex_);
  Writer* writer = find(sample->writer);
  if (writer == nullptr || !writer->connected || !wants(*sample)) return false;
  if (sample->addressee != 0) {
    writer->history_first = false;
  }
  if (writer->history_first || sample->sequence <= writer->newest) return false;
  writer->newest = sample->sequence;
  ++writer->arrivals;
  queue_.push_back(std::move(sample));
  keep_newest([id = writer->id](const Writer& w) { return w.id == id; }, surplus);
  return true;
}

bool FakeInbox::wants(const SampleBuffer& sample) const {
  const bool for_one = sample.addressee != 0;
  if (for_one && sample.addressee != id_) return false;
  return std::ranges::any_of(accepted_, [&](const core::Accepted& a) {
    return (for_one || a.wanted.min_period_us == sample.min_period_us) &&
           a.wanted.selection.mask() == sample.mask && a.wanted.selection.parts_hash() == sample.parts;
  });
}

/// Removes the oldest counted samples until `depth` of them are left. A sample counts if `is_counted` is true
/// for its writer.
template <class Condition>
void FakeInbox::keep_newest(Condition is_counted, std::vector<SampleHandle>& surplus) {
  const auto counted = [&](const SampleHandle& sample) { return is_counted(*find(sample->writer)); };
  for (auto kept = std::ranges::count_if(queue_, counted); kept > static_cast<std::ptrdiff_t>(depth_);
       --kept) {
    const auto oldest = std::ranges::find_if(queue_, counted);
    ++find((*oldest)->writer)->dropped;
    ++discarded_;
    surplus.push_back(std::move(*oldest));
    queue_.erase(oldest);
  }
}

/// Removes disconnected writers that have no samples left. Samples of such a writer that were dropped after
/// the last sample that was taken count as lost unnoticed, because no gap will show their loss.
void FakeInbox::forget_the_finished() {
  std::erase_if(writers_, [this](const Writer& writer) {
    const auto is_its = [&](const SampleHandle& sample) { return sample->writer == writer.id; };
    if (writer.connected || std::ranges::any_of(queue_, is_its)) return false;
    lost_unnoticed_ += writer.dropped;
    return true;
  });
}

SampleHandle FakeInbox::take() {
  const std::scoped_lock lock(mutex_);
  if (queue_.empty()) return {};
  SampleHandle sample = std::move(queue_.front());
  queue_.pop_front();
  Writer& writer = *find(sample->writer);
  const std::uint64_t dropped = std::exchange(writer.dropped, 0);
  if (!std::exchange(writer.begun, true) && sample->oldest_retained == 0) lost_unnoticed_ += dropped;
  forget_the_finished();
  return sample;
}

void FakeInbox::connect(const core::Source& source) {
  const std::scoped_lock lock(mutex_);
  Writer* writer = find(source.writer);
  if (writer == nullptr) writer = &writers_.emplace_back(Writer{.id = source.writer});
  writer->connected = true;
  writer->history_first = source.history_first;
}

void FakeInbox::disconnect(EndpointId id) {
  std::vector<SampleHandle> surplus;  // destroyed after the lock of the mutex is released
  const std::scoped_lock lock(mutex_);
  Writer* writer = find(id);
  if (writer == nullptr) return;
  writer->connected = false;
  keep_newest([](const Writer& w) { return !w.connected; }, surplus);
  forget_the_finished();
}

void FakeInbox::accept(std::vector<core::Accepted> accepted) {
  const std::scoped_lock lock(mutex_);
  accepted_ = std::move(accepted);
}

bool FakeInbox::connected(EndpointId id) const {
  const std::scoped_lock lock(mutex_);
  const Writer* writer = find(id);
  return writer != nullptr && writer->connected;
}

HistoryProgress FakeInbox::history(EndpointId id) const {
  const std::scoped_lock lock(mutex_);
  const Writer* writer = find(id);
  return writer == nullptr || writer->history_first ? HistoryProgress::awaited : HistoryProgress::came;
}

std::uint64_t FakeInbox::arrivals(EndpointId id) const {
  const std::scoped_lock lock(mutex_);
  const Writer* writer = find(id);
  return writer == nullptr ? 0 : writer->arrivals;
}

std::uint64_t FakeInbox::discarded() const {
  const std::scoped_lock lock(mutex_);
  return discarded_;
}

std::uint64_t FakeInbox::lost_unnoticed() const {
  const std::scoped_lock lock(mutex_);
  return lost_unnoticed_;
}

const FakeInbox::Writer* FakeInbox::find(EndpointId id) const {
  const auto found = std::ranges::find(writers_, id, &Writer::id);
  return found == writers_.end() ? nullptr : &*found;
}

FakeInbox::Writer* FakeInbox::find(EndpointId id) {
  return const_cast<Writer*>(std::as_const(*this).find(id));
}

}  // namespace sft::test
