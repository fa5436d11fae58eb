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

namespace sft::shm {

/// A task for the waker. Its functions are const, so that a task can be part of an object that does not
/// change.
class WakeTask {
 public:
  /// Performs the task. The waker calls this on its thread, at least once after each Waker::submit().
  virtual void run() const noexcept = 0;

 protected:
  ~WakeTask() = default;

 private:
  friend class Waker;
  mutable std::atomic<bool> queued_{false};
  /// A reference to the task itself, which keeps it alive while it is queued.
  mutable std::shared_ptr<const WakeTask> self_;
  mutable const WakeTask* next_ = nullptr;
};

class Waker {
 public:
  explicit Waker(core::ThreadSpec spec = "sft-wake") : spec_(std::move(spec)) {}
  /// Runs the tasks that are still queued.
  ~Waker();
  Waker(const Waker&) = delete;
  Waker& operator=(const Waker&) = delete;

  /// Starts the thread if it does not run. If the system gives no thread, the next call tries again. Any
  /// thread may call this.
  void start();

  /// Queues the task and returns at once, without a lock and without an allocation. Returns false if the
  /// thread does not run. Any thread may call this, but only one thread at a time for the same task.
  bool submit(const std::shared_ptr<const WakeTask>& task) noexcept;

 private:
  void serve();
  void run_all() noexcept;

  const core::ThreadSpec spec_;
  core::Doorbell bell_;
  std::atomic<const WakeTask*> submitted_{nullptr};  ///< a list of tasks, the latest first
  std::atomic<bool> running_{false};
  std::atomic<bool> stopping_{false};
  core::Mutex mutex_;
  std::thread thread_ SFT_GUARDED_BY(mutex_);
};

}  // namespace sft::shm
