// Decides when a node makes itself known again, in addition to the rare times that Cyclone does it by itself:
// often at first, since a greeting may get lost, and then only while somebody is missing. Pure.
#pragma once

#include <chrono>
#include <cstddef>
#include <optional>

#include "core/platform/clock.h"

namespace sft::core {

class Greetings {
 public:
  explicit Greetings(Time now) { begin(now); }

  /// Begins anew, as at the start: others may reach us now that could not before.
  void begin(Time now);
  /// Somebody is heard for the first time, and may not have received our answer: after a change of network it
  /// may not know yet where we are. One greeting serves a whole crowd of newcomers.
  void newcomer(Time now);
  /// A pulse has come that counts for nothing, since its participant is not known, or not yet. After a cable
  /// was pulled for long, that is all that shows that others are there again. Anybody can send such pulses,
  /// so greetings for strangers become rarer as long as some are heard.
  void stranger(Time now);
  /// There are so many other participants, of which some may be made up. Everybody has to read each greeting,
  /// so those of a crowd are rarer: while many nodes start, they would take the time in which these meet.
  void others(std::size_t participants);
  /// True if a greeting is due now, which then counts as sent. Asked often.
  bool due(Time now, bool somebody_is_missing);
  /// When the next greeting is due if nobody is missing; Time::max() if none is.
  Time next() const;

 private:
  Time next_{};
  Time last_{};
  std::optional<Time> for_newcomer_{};
  struct Strangers {
    Time heard{};  ///< last
    Time next{};   ///< greeting, if they are heard until then
    std::chrono::milliseconds pause{};
  };
  bool due_for_strangers(Time now);

  std::optional<Strangers> strangers_{};
  std::chrono::milliseconds pause_{};
  std::chrono::milliseconds pause_in_crowd_{};  ///< at least
};

}  // namespace sft::core
