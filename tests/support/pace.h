// Helpers that repeat an action at a rate.
#pragma once

#include <poll.h>

#include <chrono>
#include <cstdint>
#include <ctime>
#include <functional>
#include <stop_token>
#include <thread>
#include <utility>

namespace sft::test {

/// The meaning of a period. `pause`: the time between two calls. `rate`: the average time per call, so that
/// a thread that is late makes several calls at once.
enum class Keeps : std::uint8_t { pause, rate };

class Pace {
 public:
  explicit Pace(std::chrono::nanoseconds period, Keeps keeps = Keeps::pause)
      : period_(period), keeps_(keeps) {}

  void await_turn() {
    turn_ = (keeps_ == Keeps::rate ? turn_ : Clock::now()) + period_;
    for (auto left = turn_ - Clock::now(); left.count() > 0; left = turn_ - Clock::now()) {
      const auto seconds = std::chrono::floor<std::chrono::seconds>(left);
      const timespec time{seconds.count(), (left - seconds).count()};
      ppoll(nullptr, 0, &time, nullptr);
    }
  }

 private:
  using Clock = std::chrono::steady_clock;

  std::chrono::nanoseconds period_;
  Keeps keeps_;
  Clock::time_point turn_ = Clock::now();
};

/// Calls `tick` with 1, 2, 3 and so on, on a thread of its own, until this object is destroyed.
class Ticker {
 public:
  Ticker(std::chrono::nanoseconds period, std::function<void(std::uint32_t)> tick, Keeps keeps = Keeps::pause)
      : thread_([period, keeps, tick = std::move(tick)](const std::stop_token& stop) {
          Pace pace(period, keeps);
          for (std::uint32_t i = 1; !stop.stop_requested(); ++i) {
            tick(i);
            pace.await_turn();
          }
        }) {}

 private:
  std::jthread thread_;
};

}  // namespace sft::test
