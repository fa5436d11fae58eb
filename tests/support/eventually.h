// Waiting for a condition that other threads or processes bring about, with a deadline.
#pragma once

#include <poll.h>

#include <chrono>

namespace sft::test {

/// Looks every millisecond; false if the condition does not hold in time.
template <class Condition>
bool eventually(Condition&& condition, std::chrono::milliseconds within = std::chrono::seconds(15)) {
  const auto deadline = std::chrono::steady_clock::now() + within;
  while (!condition()) {
    if (std::chrono::steady_clock::now() >= deadline) return false;
    poll(nullptr, 0, 1);
  }
  return true;
}

}  // namespace sft::test
