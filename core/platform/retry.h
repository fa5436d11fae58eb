// Decides when something that failed is tried again, ever more seldom. The reason is told once for as long as
// it stays the same. Pure.
#pragma once

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>

#include "core/platform/clock.h"

namespace sft::core {

class Retry {
 public:
  static constexpr std::chrono::milliseconds pause_min{500};
  static constexpr std::chrono::milliseconds pause_max{10'000};

  /// True if it may be tried.
  bool due(Time now) const { return now >= next_; }
  /// True if it has failed, and may be tried again.
  bool due_again(Time now) const { return pause_.count() != 0 && due(now); }

  /// Returns true if that is news: it did not fail before, or failed for another reason. `longest`: the
  /// longest pause until it may be tried again.
  bool failed(std::string why, Time now, std::chrono::milliseconds longest = pause_max) {
    pause_ = std::clamp(pause_ * 2, pause_min, longest);
    next_ = now + pause_;
    const bool is_news = why != why_;
    why_ = std::move(why);
    return is_news;
  }
  void succeeded() { *this = {}; }
  /// Returns the time from which on it may be tried again, or Time{} if it did not fail.
  Time next() const { return next_; }
  /// The reason of the last failure.
  const std::string& reason() const { return why_; }
  /// Pauses it until then, although it did not fail.
  void hold(Time until) {
    next_ = until;
    pause_ = std::max(pause_, std::chrono::milliseconds(1));
  }
  void hold(Time until, std::string why) {
    hold(until);
    why_ = std::move(why);
  }
  /// Pauses it for as long as the other one pauses, and for the same reason.
  void hold_with(const Retry& other) {
    hold(other.next_);
    why_ = other.why_;
  }

 private:
  Time next_{};
  std::chrono::milliseconds pause_{0};
  std::string why_;
};

}  // namespace sft::core
