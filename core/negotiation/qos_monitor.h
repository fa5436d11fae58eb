// Watches promises: deadlines and liveliness, of our writers and of those that our readers hear. Pure: counts
// of what has happened and times go in, answers come out. Publishers and subscribers only count, which they
// do anyway. So a sign is as old as the look that found it, and a look is due twice in a period: a missed
// deadline is told up to half a period later.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "core/control/qos.h"
#include "core/platform/clock.h"

namespace sft::core {

/// A count that should change at least once in each period.
class ActivityMonitor {
 public:
  ActivityMonitor(std::chrono::nanoseconds period, std::uint64_t count, Time now)
      : period_(period), count_(count), active_at_(now) {}

  /// Returns the periods that have ended without a sign, beyond those that were told before.
  std::uint64_t look(std::uint64_t count, Time now);
  /// True if no sign had come in time at the last look.
  bool quiet() const { return reported_ != 0; }
  std::chrono::nanoseconds pace() const { return period_ / 2; }

 private:
  std::chrono::nanoseconds period_;
  std::uint64_t count_;
  Time active_at_;
  std::uint64_t reported_ = 0;  ///< periods since then
};

/// Watches what one of our writers offers, and when its readers have to be told that it lives.
class OfferMonitor {
 public:
  struct Signs {
    std::uint64_t published = 0;
    std::uint64_t asserted = 0;  ///< explicit assertions of liveliness
  };
  OfferMonitor(const Qos& offered, Time now);

  void look(const Signs& signs, Time now);
  std::uint64_t deadlines_missed() const { return deadlines_missed_; }
  bool alive() const { return !lease_ || !lease_->quiet(); }

  /// True if an assertion should be sent, which then counts as sent. Samples are signs of life themselves if
  /// `samples_assert`: if every reader that wants to know gets each of them. Asked often.
  bool assertion_due(const Signs& signs, bool samples_assert, Time now);
  /// True while assertions of the program are not sent one by one.
  bool rests(Time now) const { return now < reported_at_ + qos_.liveliness_lease / assertions_per_lease; }

  /// Returns the time between two looks; empty if there is nothing to watch.
  std::optional<std::chrono::nanoseconds> pace() const;

 private:
  static constexpr int assertions_per_lease = 3;  // two may get lost

  Qos qos_;
  std::optional<ActivityMonitor> deadline_;
  std::optional<ActivityMonitor> lease_;  ///< where the program has to assert
  std::uint64_t deadlines_missed_ = 0;
  Signs reported_;  ///< what readers know of
  Time reported_at_ = Time::min();
};

/// Watches one writer for one of our readers that has asked for something.
class RequestMonitor {
 public:
  /// The shortest lease of a writer that is watched. If less is offered, the requested lease is watched.
  static constexpr std::chrono::milliseconds shortest_offer{10};

  /// `arrived` changes with each sample that arrives.
  RequestMonitor(const Qos& offered, const Qos& requested, std::uint64_t arrived, Time now);

  /// Returns how many deadlines were missed since the look before.
  std::uint64_t look(std::uint64_t arrived, Time now);
  void asserted() { ++assertions_; }
  bool alive() const { return !lease_ || !lease_->quiet(); }
  std::optional<std::chrono::nanoseconds> pace() const;

 private:
  std::optional<ActivityMonitor> deadline_;
  std::optional<ActivityMonitor> lease_;
  std::uint64_t assertions_ = 0;
};

}  // namespace sft::core
