// Waits, with a deadline, for a condition that other threads or processes make true.
#pragma once

#include <poll.h>

#include <chrono>

namespace sft::test {

/// A time limit that no operation exceeds unless it hangs, however busy the machine is. An operation that
/// takes longer counts as hanging. Benchmarks, not tests, measure the speed of operations.
inline constexpr std::chrono::seconds hang_timeout{60};

/// Checks the condition again after each pause. Returns false if the condition does not hold before the
/// time `within` is over.
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
