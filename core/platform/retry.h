// Decides when a failed action is tried again, with growing pauses. As long as the reason of the failures
// stays the same, it is reported as new only once. The class uses no clock: times are passed in, decisions
// are returned.
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

  /// Returns true if an attempt may be made.
  bool due(Time now) const { return now >= next_; }
  /// Returns true if the last attempt has failed, and another one may be made.
  bool due_again(Time now) const { return pause_.count() != 0 && due(now); }

  /// Called when an attempt has failed. Returns true if the failure is new: the previous attempt did not
  /// fail, or failed for another reason. `longest` limits the pause until the next attempt.
  bool failed(std::string why, Time now, std::chrono::milliseconds longest = pause_max) {
    pause_ = std::clamp(pause_ * 2, pause_min, longest);
    next_ = now + pause_;
    const bool is_news = why != why_;
    why_ = std::move(why);
    return is_news;
  }
  void succeeded() { *this = {}; }
  /// Returns the earliest time of the next attempt, or Time{} if the last one did not fail.
  Time next() const { return next_; }
  /// Returns the reason of the last failure.
  const std::string& reason() const { return why_; }
  /// Forbids attempts until the given time, although no attempt has failed.
  void hold(Time until) {
    next_ = until;
    pause_ = std::max(pause_, std::chrono::milliseconds(1));
  }
  void hold(Time until, std::string why) {
    hold(until);
    why_ = std::move(why);
  }
  /// Forbids attempts as long as `other` does, and adopts the reason of `other`.
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
