#include "core/platform/forked.h"

#include <pthread.h>

#include <atomic>

namespace sft::core {

namespace {

std::atomic<int> living{0};
std::atomic<bool> forked_copy{false};

void note_fork() {
  if (living.load(std::memory_order_relaxed) > 0) forked_copy.store(true, std::memory_order_relaxed);
}

const int watches_forks = pthread_atfork(nullptr, nullptr, &note_fork);

}  // namespace

OfOneProcess::OfOneProcess() noexcept {
  static_cast<void>(watches_forks);
  living.fetch_add(1, std::memory_order_relaxed);
}

OfOneProcess::~OfOneProcess() { living.fetch_sub(1, std::memory_order_relaxed); }

bool is_forked_copy() noexcept { return forked_copy.load(std::memory_order_relaxed); }

}  // namespace sft::core
