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
  const std::scoped_lock lock(mutex_);
  if (thread_.joinable()) return;
  auto started = core::start_thread(spec_, [this] { serve(); });
  if (!started) return;
  thread_ = std::move(*started);
  running_.store(true);
}

bool Waker::run(const std::shared_ptr<const Errand>& errand) noexcept {
  if (!running_.load(std::memory_order_relaxed)) return false;
  // Whoever finds it listed has made known what is to be done before the waker takes it off the list.
  if (errand->listed_.exchange(true, std::memory_order_acq_rel)) return true;
  errand->self_ = errand;
  errand->next_ = listed_.load(std::memory_order_relaxed);
  while (!listed_.compare_exchange_weak(errand->next_, errand.get(), std::memory_order_seq_cst)) {
  }
  bell_.ring();
  return true;
}

void Waker::serve() {
  while (!stopping_.load()) {
    run_all();
    bell_.wait(std::chrono::steady_clock::time_point::max(),
               [this] { return stopping_.load() || listed_.load() != nullptr; });
  }
  run_all();
}

void Waker::run_all() noexcept {
  const Errand* next = listed_.exchange(nullptr, std::memory_order_seq_cst);
  while (next != nullptr) {
    const Errand& errand = *next;
    next = errand.next_;
    const std::shared_ptr<const Errand> held = std::move(errand.self_);
    // From here on it may be listed again.
    errand.listed_.exchange(false, std::memory_order_acq_rel);
    errand.run();
  }
}

}  // namespace sft::shm
