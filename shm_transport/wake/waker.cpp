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

bool Waker::submit(const std::shared_ptr<const Doorbells>& bells) noexcept {
  if (!running_.load(std::memory_order_relaxed)) return false;
  // If the doorbells are queued already, their next turn also covers this call: the exchange makes the
  // caller's writes visible to the waker, which clears the flag before it wakes readers.
  if (bells->queued_.exchange(true, std::memory_order_acq_rel)) return true;
  bells->self_ = bells;
  bells->next_ = submitted_.load(std::memory_order_relaxed);
  while (!submitted_.compare_exchange_weak(bells->next_, bells.get(), std::memory_order_seq_cst)) {
  }
  bell_.ring();
  return true;
}

void Waker::serve() {
  while (!stopping_.load()) {
    wake_all();
    bell_.wait(std::chrono::steady_clock::time_point::max(),
               [this] { return stopping_.load() || submitted_.load() != nullptr; });
  }
  wake_all();
}

void Waker::wake_all() noexcept {
  const Doorbells* next = submitted_.exchange(nullptr, std::memory_order_seq_cst);
  while (next != nullptr) {
    const Doorbells& bells = *next;
    next = bells.next_;
    const std::shared_ptr<const Doorbells> held = std::move(bells.self_);
    // The doorbells may be queued again from here on.
    bells.queued_.exchange(false, std::memory_order_acq_rel);
    bells.wake();
  }
}

void ring(const std::shared_ptr<const Doorbells>& bells, Waker& waker) noexcept {
  const std::size_t sleepers = bells->announce();
  if (sleepers == 0) return;
  // The waker thread has to be woken, too. So for a single sleeping reader, the waker thread would save no
  // time and delay the reader.
  if (sleepers == 1 || !waker.submit(bells)) bells->wake();
}

}  // namespace sft::shm
