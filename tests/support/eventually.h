// Waits, with a deadline, for a condition that other threads or processes fulfil.
#pragma once

#include <poll.h>

#include <chrono>

namespace sft::test {

/// Anything that must happen happens within this time on any machine, however busy. What takes longer counts
/// as hanging. Benchmarks, not tests, measure how fast something is.
inline constexpr std::chrono::seconds hang_timeout{60};

/// Checks the condition again after each pause. Returns false if it does not hold in time.
template <class Condition>
bool eventually(Condition&& condition, std::chrono::milliseconds within = hang_timeout,
                std::chrono::milliseconds pause = std::chrono::milliseconds(1)) {
  const auto deadline = std::chrono::steady_clock::now() + within;
  while (!condition()) {
    if (std::chrono::steady_clock::now() >= deadline) return false;
    poll(nullptr, 0, static_cast<int>(pause.count()));
  }
  return true;
}

}  // namespace sft::test
