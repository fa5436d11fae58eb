// The thread that wakes readers for the publishers of a node. Each wake-up is a futex call, so a publisher
// that woke several readers itself would return late. The thread starts when a publisher first needs it.
// While the thread does not run, publishers wake all readers themselves.
#pragma once

#include <atomic>
#include <memory>
#include <thread>
#include <utility>

#include "core/platform/doorbell.h"
#include "core/platform/thread.h"
#include "core/sync/mutex.h"
#include "shm_transport/wake/doorbells.h"

namespace sft::shm {

class Waker {
 public:
  explicit Waker(core::ThreadSpec spec = "sft-wake") : spec_(std::move(spec)) {}
  /// Wakes the readers whose doorbells are still queued.
  ~Waker();
  Waker(const Waker&) = delete;
  Waker& operator=(const Waker&) = delete;

  /// Starts the thread if it does not run. If the system gives no thread, the next call tries again. Any
  /// thread may call this.
  void start();

  /// Queues Doorbells::wake(), which the thread calls at least once after this. Returns at once, without a
  /// lock and without an allocation. Returns false if the thread does not run. Any thread may call this, but
  /// only one thread at a time for the same doorbells.
  bool submit(const std::shared_ptr<const Doorbells>& bells) noexcept;

 private:
  void serve();
  void wake_all() noexcept;

  const core::ThreadSpec spec_;
  core::Doorbell bell_;
  std::atomic<const Doorbells*> submitted_{nullptr};  ///< a list, the latest first
  std::atomic<bool> running_{false};
  std::atomic<bool> stopping_{false};
  core::Mutex mutex_;
  std::thread thread_ SFT_GUARDED_BY(mutex_);
};

/// Rings the doorbells for the current sample. Must be called on the thread of the publisher. This thread
/// wakes a single sleeping reader itself. If several readers sleep, the waker wakes them.
void ring(const std::shared_ptr<const Doorbells>& bells, Waker& waker) noexcept;

}  // namespace sft::shm
