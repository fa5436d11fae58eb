// When a node makes itself known again, beside the rare times that Cyclone does it by itself: often at first,
// since a greeting may get lost, and then only while somebody is missing. Pure: times in, answers out.
#pragma once

#include <chrono>
#include <optional>

namespace sft::core {

class Greetings {
 public:
  using Now = std::chrono::steady_clock::time_point;

  explicit Greetings(Now now) { begin(now); }

  /// As at the start: others may reach us now that could not before.
  void begin(Now now);
  /// Somebody is heard for the first time, and may not have got what we answered: after a change of network
  /// it may not know yet where we are. In a crowd of newcomers one greeting is for many.
  void newcomer(Now now);
  /// Whether to greet now, which then counts as done. Asked often.
  bool due(Now now, bool somebody_is_missing);

 private:
  Now next_{};
  Now last_{};
  std::optional<Now> for_newcomer_{};
  std::chrono::milliseconds pause_{};
};

}  // namespace sft::core
