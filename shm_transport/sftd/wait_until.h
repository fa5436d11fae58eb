// Waits for a condition that no event announces.
#pragma once

#include <chrono>
#include <thread>

namespace sft::shm {

/// Checks the condition repeatedly, with pauses of length `pause`, until it is true or `timeout` is over.
/// Returns whether the condition became true.
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
