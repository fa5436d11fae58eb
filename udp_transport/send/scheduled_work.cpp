#include "udp_transport/send/scheduled_work.h"

#include <utility>

namespace sft::udp {

namespace {
/// Adds to one of two lists, which take() exchanges. The list at once gets the greatest capacity that either
/// list has had, instead of growing step by step.
template <class One>
void add_to(std::vector<One>& list, One one, std::size_t& room) {
  list.reserve(room);
  list.push_back(std::move(one));
  room = list.capacity();
}
}  // namespace

void ScheduledWork::add(std::shared_ptr<Lane> lane) {
  bool first = false;
  {
    const core::Lock lock(mutex_);
    if (is_closed_) return;
    first = added_.lanes.empty();
    add_to(added_.lanes, std::move(lane), room_.lanes);
  }
  if (first) io_.wake();
}

void ScheduledWork::add(std::shared_ptr<Channel> channel) {
  {
    const core::Lock lock(mutex_);
    if (is_closed_) return;
    add_to(added_.channels, std::move(channel), room_.channels);
  }
  io_.wake();
}

void ScheduledWork::add(std::shared_ptr<DeferredWork> work) noexcept {
  {
    const core::Lock lock(mutex_);
    if (is_closed_) return;
    work->next_ = std::exchange(deferred_, work);
    any_deferred_.store(true, std::memory_order_release);
  }
  io_.wake();
}

void ScheduledWork::close() {
  const core::Lock lock(mutex_);
  is_closed_ = true;
  added_.lanes.clear();
  added_.channels.clear();
  deferred_.reset();
}

/// Lists are exchanged only if work was added. So after two exchanges, the publisher's thread does not
/// allocate any more, however often the sending thread has found no work.
void ScheduledWork::take(Taken& taken) {
  const core::Lock lock(mutex_);
  if (!added_.lanes.empty()) taken.lanes.swap(added_.lanes);
  if (!added_.channels.empty()) taken.channels.swap(added_.channels);
}

void ScheduledWork::carry_out_all_deferred() {
  std::shared_ptr<DeferredWork> work;
  {
    const core::Lock lock(mutex_);
    work.swap(deferred_);
    any_deferred_.store(false, std::memory_order_relaxed);
  }
  while (work != nullptr) {
    // This is moved first, because the work may be scheduled again at once.
    std::shared_ptr<DeferredWork> next = std::move(work->next_);
    if (work->carry_out()) add(work);
    work = std::move(next);
  }
}

}  // namespace sft::udp
