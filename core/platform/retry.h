// Something that failed and is tried again, ever more seldom, and whose reason for failing is told once for
// as long as it stays the same. Pure.
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

  /// Whether it may be tried.
  bool due(Now now) const { return now >= next_; }
  /// Whether it has failed, and may be tried again.
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
  /// Why it failed last.
  const std::string& reason() const { return why_; }
  /// Not to be tried before that, although it did not fail.
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
