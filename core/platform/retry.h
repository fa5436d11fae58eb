// This class times the attempts at something that has failed: each pause is longer than the one before. It
// also tells whether the reason of a failure is new, so that the reason is reported once. The class is pure.
#pragma once

#include <algorithm>
#include <chrono>
#include <string>
#include <utility>

namespace sft::core {

class Retry {
 public:
  using Now = std::chrono::steady_clock::time_point;
  static constexpr std::chrono::milliseconds pause_min{500};
  static constexpr std::chrono::milliseconds pause_max{10'000};

  /// True if the next attempt may be made.
  bool due(Now now) const { return now >= next_; }
  /// True if the last attempt failed, and the next one may be made.
  bool due_again(Now now) const { return pause_.count() != 0 && due(now); }

  /// Returns whether that is news: it did not fail before, or for another reason. `longest`: until it may be
  /// tried again.
  bool failed(std::string why, Now now, std::chrono::milliseconds longest = pause_max) {
    pause_ = std::clamp(pause_ * 2, pause_min, longest);
    next_ = now + pause_;
    const bool is_news = why != why_;
    why_ = std::move(why);
    return is_news;
  }
  void succeeded() { *this = {}; }
  /// The reason of the last failure.
  const std::string& reason() const { return why_; }
  /// Postpones the next attempt to that time, although none failed.
  void hold(Now until) {
    next_ = until;
    pause_ = std::max(pause_, std::chrono::milliseconds(1));
  }

 private:
  Now next_{};
  std::chrono::milliseconds pause_{0};
  std::string why_;
};

}  // namespace sft::core
