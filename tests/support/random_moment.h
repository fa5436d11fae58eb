// Two sides that meet at moments that differ a little from round to round, so that over many rounds they
// meet in every order.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <thread>

#include "tests/support/test_seed.h"

namespace sft::test {

/// One side's own moments.
class RandomMoment {
 public:
  explicit RandomMoment(std::uint64_t side) : random_(test_seed() + side) {}

  /// Passes between nothing and some microseconds, short times more often; now and then lets others run
  /// first.
  void pass() {
    const std::uint64_t random = random_();
    const std::uint64_t steps = (random >> 8) % (std::uint64_t{1} << (random % 13));
    for (std::uint64_t i = 0; i < steps; ++i) std::atomic_signal_fence(std::memory_order_seq_cst);
    if ((random >> 60) == 0) std::this_thread::yield();
  }

 private:
  Random random_;
};

/// One side waits here for the other at the end of a round, without using anything that is under test.
/// Returns false if the other side did not come for long.
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
