// A wait for another thread that will soon be done.
#pragma once

#include <chrono>
#include <thread>

namespace sft::core {

/// Waits until `done()` returns true. The function sleeps after a few checks, because the other thread may
/// need this processor.
template <class Done>
void wait_until(Done done) {
  constexpr int yields = 32;
  constexpr std::chrono::microseconds pause{20};
  for (int i = 0; !done(); ++i) {
    i < yields ? std::this_thread::yield() : std::this_thread::sleep_for(pause);
  }
}

}  // namespace sft::core
