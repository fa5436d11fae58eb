// Decides when the demo says what it waits for: at once when it begins to wait for something else, and then
// once in a second, so that it is never silent for long.
#pragma once

#include <chrono>
#include <optional>
#include <string>
#include <string_view>

namespace sft::demo {

class WaitNotice {
 public:
  using Clock = std::chrono::steady_clock;
  /// The longest silence, if line() is called often enough.
  static constexpr std::chrono::seconds interval{1};

  /// Returns the line that is due ("Waiting for the health ... 3 s"), or nothing. `what` is the sentence
  /// without its end.
  std::optional<std::string> line(std::string_view what, Clock::time_point now);

 private:
  std::string what_;
  Clock::time_point since_;
  Clock::time_point said_;
};

}  // namespace sft::demo
