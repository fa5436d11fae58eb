// Busy waiting for events that will happen sooner than a sleeping thread could be woken.
#pragma once

#include <sched.h>

#include <chrono>

namespace sft::core {

/// Hints to the core that the thread is in a waiting loop.
inline void pause_core() {
#if defined(__x86_64__)
  __builtin_ia32_pause();
#elif defined(__aarch64__)
  asm volatile("yield");
#endif
}

/// Spins until `over()` returns true, and then returns true. Returns false if the time `until` has come
/// without that. The thread yields to threads that wait for this core, since one of them may cause the
/// event.
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
