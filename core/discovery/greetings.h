// When a node makes itself known again, beside the rare times that Cyclone does it by itself: often at first,
// since a greeting may get lost, and then only while somebody is missing. Pure: times in, answers out.
#pragma once

#include <chrono>
#include <optional>

#include "core/platform/clock.h"

namespace sft::core {

class Greetings {
 public:
  explicit Greetings(Time now) { begin(now); }

  /// As at the start: others may reach us now that could not before.
  void begin(Time now);
  /// Somebody is heard for the first time, and may not have got what we answered: after a change of network
  /// it may not know yet where we are. In a crowd of newcomers one greeting is for many.
  void newcomer(Time now);
  /// Whether to greet now, which then counts as done. Asked often.
  bool due(Time now, bool somebody_is_missing);

 private:
  Time next_{};
  Time last_{};
  std::optional<Time> for_newcomer_{};
  std::chrono::milliseconds pause_{};
};

}  // namespace sft::core
