// Waiting with the core kept busy: for what comes sooner than a sleeping thread could be woken.
#pragma once

#include <sched.h>

#include <chrono>

namespace sft::core {

/// Tells the core that this is a loop that waits.
inline void pause_core() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

/// Spins until `over()` holds or the time is over, and tells which. Yields to threads that wait for this
/// core: one of them may bring about what is waited for.
template <class Over>
bool spin(std::chrono::steady_clock::time_point until, Over&& over) {
  constexpr int looks_per_yield = 8;
  while (std::chrono::steady_clock::now() < until) {
    for (int i = 0; i < looks_per_yield; ++i) {
      if (over()) return true;
      pause_core();
    }
    ::sched_yield();
  }
  return false;
}

}  // namespace sft::core
