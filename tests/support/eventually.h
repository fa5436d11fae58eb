// Waiting for a condition that other threads or processes bring about, with a deadline.
#pragma once

#include <poll.h>

#include <chrono>

namespace sft::test {

/// What must happen happens within this time on any machine, however busy: what takes longer hangs. How fast
/// something is belongs to a benchmark.
inline constexpr std::chrono::seconds hang_timeout{60};

/// Looks again after each pause; false if the condition does not hold in time.
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
