#include "udp_transport/receive/inbox.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace sft::udp {

namespace {
template <class Writers>
auto* find_in(Writers& writers, core::EndpointId id) noexcept {
  const auto found = std::find_if(writers.begin(), writers.end(), [&](const auto& w) { return w.id == id; });
  return found == writers.end() ? nullptr : &*found;
}
}  // namespace

void Inbox::deliver(std::span<core::SampleHandle> samples, KeepLastQueue::Excess excess) noexcept {
  while (!samples.empty()) {
    Enqueued enqueued;
    {
      const core::Lock lock(mutex_);
      enqueued = enqueue_some(samples, excess);
    }
    for (core::SampleHandle& pushed_out : samples.first(enqueued.samples)) pushed_out.reset();
    samples = samples.subspan(enqueued.samples);
    if (enqueued.kept > 0) notify_listener_();
  }
}

KeepLastQueue::Room Inbox::room(core::EndpointId id) const noexcept {
  const core::Lock lock(mutex_);
  const Writer* writer = find(id);
  return writer == nullptr ? KeepLastQueue(depth_, depth_bytes_).room() : writer->queue.room();
}

/// Enqueues samples until as many as can wait at a time are kept.
Inbox::Enqueued Inbox::enqueue_some(std::span<core::SampleHandle> samples,
                                    KeepLastQueue::Excess excess) noexcept {
  Enqueued enqueued;
  while (enqueued.samples < samples.size() && enqueued.kept < depth_)
    enqueued.kept += enqueue(samples[enqueued.samples++], excess) ? 1 : 0;
  return enqueued;
}

/// Enqueues the sample. Returns true if it was kept. If `sample` is not null afterwards, it is a refused or
/// displaced sample, which the caller must release without the lock.
bool Inbox::enqueue(core::SampleHandle& sample, KeepLastQueue::Excess excess) noexcept {
  Writer* writer = find(sample->header().writer);
  if (writer == nullptr || !writer->connected) return false;
  if (writer->filter.is_late() && !writer->filter.takes(*sample, std::chrono::steady_clock::now()))
    return false;  // such a sample is for other readers, or will come again later, in order
  ++writer->arrivals;
  const KeepLastQueue::Put put = writer->queue.put(sample, ++arrivals_, excess);
  const std::size_t dropped = writer->queue.take_dropped();
  discarded_ += dropped;
  writer->dropped += dropped;
  switch (put) {
    case KeepLastQueue::Put::kept:
      return true;
    case KeepLastQueue::Put::pushed_out:
      ++discarded_;
      ++writer->dropped;
      return true;
    case KeepLastQueue::Put::late:
      // A late reader's sample is not counted as discarded, because it may have come twice: for all readers
      // and for this one.
      if (!writer->filter.is_late()) ++discarded_;
      return false;
    case KeepLastQueue::Put::repeated:
      return false;
  }
  return false;
}

template <class Condition>
Inbox::Writer* Inbox::first_to_come(Condition condition) noexcept {
  Writer* first = nullptr;
  for (Writer& writer : writers_) {
    if (writer.queue.empty() || !condition(writer)) continue;
    if (first == nullptr || writer.queue.arrival() < first->queue.arrival()) first = &writer;
  }
  return first;
}

core::SampleHandle Inbox::take() noexcept {
  const core::Lock lock(mutex_);
  Writer* first = first_to_come([](const Writer&) { return true; });
  if (first == nullptr) return {};
  core::SampleHandle sample = first->queue.pop();
  const std::uint64_t dropped = std::exchange(first->dropped, 0);
  if (!std::exchange(first->taken, true) && sample->oldest_retained == 0)
    lost_unnoticed_ += dropped;  // the reader could not know the first sequence of the writer
  forget_the_finished();
  return sample;
}

void Inbox::connect(const core::Source& source) {
  const core::Lock lock(mutex_);
  Writer* writer = find(source.writer);
  if (writer == nullptr)
    writer = &writers_.emplace_back(Writer{source.writer, KeepLastQueue(depth_, depth_bytes_)});
  writer->connected = true;
  writer->filter = LateFilter(source.history_first);
}

void Inbox::disconnect(core::EndpointId id) noexcept {
  {
    const core::Lock lock(mutex_);
    if (Writer* writer = find(id); writer != nullptr) writer->connected = false;
    forget_the_finished();
  }
  while (drop_surplus()) {
  }
}

void Inbox::forget_the_finished() noexcept {
  std::erase_if(writers_, [](const Writer& w) { return !w.connected && w.queue.empty(); });
}

/// Removes and returns the oldest sample of the disconnected writers, if they keep more samples or bytes than
/// allowed. The caller releases it without the lock. Returns null if they do not keep too many.
core::SampleHandle Inbox::drop_surplus() noexcept {
  const auto departed = [](const Writer& w) { return !w.connected; };
  const core::Lock lock(mutex_);
  std::size_t kept = 0;
  std::uint64_t bytes = 0;
  for (const Writer& writer : writers_) {
    if (!departed(writer)) continue;
    kept += writer.queue.size();
    bytes += writer.queue.bytes();
  }
  const bool has_too_many_bytes = depth_bytes_ != 0 && bytes > depth_bytes_ && kept > 1;
  if (kept <= depth_ && !has_too_many_bytes) return {};
  Writer& first = *first_to_come(departed);
  core::SampleHandle sample = first.queue.pop();
  ++discarded_;
  ++first.dropped;
  if (first.queue.empty()) lost_unnoticed_ += first.dropped;
  forget_the_finished();
  return sample;
}

bool Inbox::connected(core::EndpointId id) const noexcept {
  const core::Lock lock(mutex_);
  const Writer* writer = find(id);
  return writer != nullptr && writer->connected;
}

core::HistoryProgress Inbox::history(core::EndpointId id) const noexcept {
  const core::Lock lock(mutex_);
  const Writer* writer = find(id);
  return writer == nullptr ? core::HistoryProgress::awaited
                           : writer->filter.progress(std::chrono::steady_clock::now());
}

std::uint64_t Inbox::arrivals(core::EndpointId id) noexcept {
  const core::Lock lock(mutex_);
  const Writer* writer = find(id);
  return writer == nullptr ? 0 : writer->arrivals;
}

std::uint64_t Inbox::discarded() const noexcept {
  const core::Lock lock(mutex_);
  return discarded_;
}

std::uint64_t Inbox::lost_unnoticed() const noexcept {
  const core::Lock lock(mutex_);
  return lost_unnoticed_;
}

Inbox::Writer* Inbox::find(core::EndpointId id) noexcept { return find_in(writers_, id); }

const Inbox::Writer* Inbox::find(core::EndpointId id) const noexcept { return find_in(writers_, id); }

}  // namespace sft::udp
