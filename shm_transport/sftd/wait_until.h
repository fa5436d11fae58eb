// Waits for a condition that no event announces.
#pragma once

#include <chrono>
#include <thread>

namespace sft::shm {

/// Checks the condition, again after each pause. Returns whether it became true before `timeout`.
template <class Condition>
bool wait_until(std::chrono::milliseconds timeout, Condition condition,
                std::chrono::milliseconds pause = std::chrono::milliseconds(1)) {
  const auto deadline = std::chrono::steady_clock::now() + timeout;
  while (!condition()) {
    if (std::chrono::steady_clock::now() >= deadline) return false;
    std::this_thread::sleep_for(pause);
  }
  return true;
}

}  // namespace sft::shm
