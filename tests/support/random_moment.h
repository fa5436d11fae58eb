// Makes two threads meet at moments that differ slightly from round to round. Over many rounds the threads'
// actions happen in every order.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <thread>

#include "tests/support/test_seed.h"

namespace sft::test {

/// The random delays of one of the two threads.
class RandomMoment {
 public:
  explicit RandomMoment(std::uint64_t side) : random_(test_seed() + side) {}

  /// Delays the thread by up to some microseconds, more often by a short time. Sometimes lets other threads
  /// run first.
  void pass() {
    const std::uint64_t random = random_();
    const std::uint64_t steps = (random >> 8) % (std::uint64_t{1} << (random % 13));
    for (std::uint64_t i = 0; i < steps; ++i) std::atomic_signal_fence(std::memory_order_seq_cst);
    if ((random >> 60) == 0) std::this_thread::yield();
  }

 private:
  Random random_;
};

/// Waits at the end of a round until the other thread's counter reaches `round`. Does not use the code under
/// test. Returns false if the counter does not reach `round` for 30 s.
template <class T>
bool comes_to(const std::atomic<T>& counter, std::uint64_t round) {
  const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(30);
  while (counter.load() < round) {
    if (std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::yield();
  }
  return true;
}

}  // namespace sft::test
