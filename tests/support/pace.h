// Doing something at a rate.
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

/// A period is either the pause between two turns, or one turn's share of the time. In the second case a
/// thread that was late takes some turns at once.
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

/// Does something for the first, second, third time and so on, on a thread of its own, until it goes.
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
