#include "udp_transport/inbox.h"

#include <algorithm>
#include <utility>

namespace sft::udp {

void Inbox::deliver(core::SampleHandle sample) noexcept {
  core::ArrivalListener* listener = nullptr;
  {
    const std::scoped_lock lock(mutex_);
    if (detached_ || !enqueue(sample)) return;
    listener = listener_;
    if (listener != nullptr) calling_ = std::this_thread::get_id();
  }
  sample.reset();  // what was pushed out
  if (listener == nullptr) return;
  listener->arrived();
  bool awaited = false;
  {
    const std::scoped_lock lock(mutex_);
    calling_ = {};
    awaited = detached_;
  }
  if (awaited) called_.notify_all();
}

/// Leaves in `sample` what is to be released without the lock.
bool Inbox::enqueue(core::SampleHandle& sample) noexcept {
  Writer* writer = find(sample->header().writer);
  if (writer == nullptr || !writer->connected) return false;
  ++writer->arrivals;
  switch (writer->queue.put(sample, ++arrivals_)) {
    case KeepLastQueue::Put::kept:
      return true;
    case KeepLastQueue::Put::pushed_out:
      ++discarded_;
      return true;
    case KeepLastQueue::Put::late:
      ++discarded_;
      return false;
    case KeepLastQueue::Put::repeated:
      return false;
  }
  return false;
}

core::SampleHandle Inbox::take() noexcept {
  const std::scoped_lock lock(mutex_);
  Writer* oldest = nullptr;
  for (Writer& writer : writers_) {
    if (writer.queue.empty()) continue;
    if (oldest == nullptr || writer.queue.arrival() < oldest->queue.arrival()) oldest = &writer;
  }
  if (oldest == nullptr) return {};
  core::SampleHandle sample = oldest->queue.pop();
  if (!oldest->connected && oldest->queue.empty())
    std::erase_if(writers_, [&](Writer& w) { return &w == oldest; });
  return sample;
}

void Inbox::connect(core::EndpointId id) {
  const std::scoped_lock lock(mutex_);
  if (Writer* known = find(id); known != nullptr) {
    known->connected = true;
  } else {
    writers_.push_back({id, KeepLastQueue(depth_), true});
  }
}

void Inbox::disconnect(core::EndpointId id) noexcept {
  const std::scoped_lock lock(mutex_);
  if (Writer* writer = find(id); writer != nullptr) writer->connected = false;
  std::erase_if(writers_, [](const Writer& w) { return !w.connected && w.queue.empty(); });
}

bool Inbox::connected(core::EndpointId id) const noexcept {
  const std::scoped_lock lock(mutex_);
  const auto found =
      std::find_if(writers_.begin(), writers_.end(), [&](const Writer& w) { return w.id == id; });
  return found != writers_.end() && found->connected;
}

std::uint64_t Inbox::arrivals(core::EndpointId id) noexcept {
  const std::scoped_lock lock(mutex_);
  const Writer* writer = find(id);
  return writer == nullptr ? 0 : writer->arrivals;
}

std::uint64_t Inbox::discarded() const noexcept {
  const std::scoped_lock lock(mutex_);
  return discarded_;
}

void Inbox::detach() noexcept {
  std::unique_lock lock(mutex_);
  detached_ = true;
  if (calling_ == std::this_thread::get_id()) return;
  called_.wait(lock, [this] { return calling_ == std::thread::id(); });
}

Inbox::Writer* Inbox::find(core::EndpointId id) noexcept {
  const auto found =
      std::find_if(writers_.begin(), writers_.end(), [&](const Writer& w) { return w.id == id; });
  return found == writers_.end() ? nullptr : &*found;
}

}  // namespace sft::udp
