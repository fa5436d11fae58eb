#include "shm_transport/wake/waker.h"

#include <chrono>
#include <utility>

namespace sft::shm {

Waker::~Waker() {
  if (!thread_.joinable()) return;
  stopping_.store(true);
  bell_.ring();
  thread_.join();
}

void Waker::start() {
  const core::Lock lock(mutex_);
  if (thread_.joinable()) return;
  auto started = core::start_thread(spec_, [this] { serve(); });
  if (!started) return;
  thread_ = std::move(*started);
  running_.store(true);
}

bool Waker::submit(const std::shared_ptr<const WakeTask>& task) noexcept {
  if (!running_.load(std::memory_order_relaxed)) return false;
  // If the task is queued already, its next run also covers this call: the exchange makes the caller's
  // writes visible to the waker, which clears the flag before it runs the task.
  if (task->queued_.exchange(true, std::memory_order_acq_rel)) return true;
  task->self_ = task;
  task->next_ = submitted_.load(std::memory_order_relaxed);
  while (!submitted_.compare_exchange_weak(task->next_, task.get(), std::memory_order_seq_cst)) {
  }
  bell_.ring();
  return true;
}

void Waker::serve() {
  while (!stopping_.load()) {
    run_all();
    bell_.wait(std::chrono::steady_clock::time_point::max(),
               [this] { return stopping_.load() || submitted_.load() != nullptr; });
  }
  run_all();
}

void Waker::run_all() noexcept {
  const WakeTask* next = submitted_.exchange(nullptr, std::memory_order_seq_cst);
  while (next != nullptr) {
    const WakeTask& task = *next;
    next = task.next_;
    const std::shared_ptr<const WakeTask> held = std::move(task.self_);
    // The task may be queued again from here on.
    task.queued_.exchange(false, std::memory_order_acq_rel);
    task.run();
  }
}

}  // namespace sft::shm
