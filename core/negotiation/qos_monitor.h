// Watches deadlines and liveliness of our writers, and of the writers from which our readers receive. Pure:
// counts and times are passed in, decisions are returned. The data path only counts samples, which it does
// in any case. A change of a count is dated by the call of look() that finds it. look() is due twice per
// period, so a missed deadline is reported up to half a period late.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "core/names/qos.h"
#include "core/platform/clock.h"

namespace sft::core {

/// A count that should change at least once in each period.
class ActivityMonitor {
 public:
  ActivityMonitor(std::chrono::nanoseconds period, std::uint64_t count, Time now)
      : period_(period), count_(count), active_at_(now) {}

  /// Returns how many periods have ended without a change of the count, apart from those returned before.
  std::uint64_t look(std::uint64_t count, Time now);
  /// Returns true if at the last look the count had not changed within its period.
  bool quiet() const { return reported_ != 0; }
  std::chrono::nanoseconds pace() const { return period_ / 2; }

 private:
  std::chrono::nanoseconds period_;
  std::uint64_t count_;
  Time active_at_;
  std::uint64_t reported_ = 0;  ///< the periods without a change since then that look() has returned
};

/// Watches whether one of our writers keeps its offer, and decides when an assertion of its liveliness has to
/// be sent to its readers.
class OfferMonitor {
 public:
  struct Signs {
    std::uint64_t published = 0;
    std::uint64_t asserted = 0;  ///< the number of explicit assertions of liveliness
  };
  OfferMonitor(const Qos& offered, Time now);

  void look(const Signs& signs, Time now);
  std::uint64_t deadlines_missed() const { return deadlines_missed_; }
  bool alive() const { return !lease_ || !lease_->quiet(); }

  /// Returns true if an assertion should be sent, which then counts as sent. `samples_assert`: every reader
  /// with a lease gets each sample, so that each sample shows that the writer is alive. Must be called
  /// often.
  bool assertion_due(const Signs& signs, bool samples_assert, Time now);
  /// Returns true while the last assertion was sent so recently that a further one need not be sent at once.
  bool rests(Time now) const { return now < reported_at_ + qos_.liveliness_lease / assertions_per_lease; }

  /// Returns the time between two looks; empty if there is nothing to watch.
  std::optional<std::chrono::nanoseconds> pace() const;

 private:
  static constexpr int assertions_per_lease = 3;  // so that two of them may get lost

  Qos qos_;
  std::optional<ActivityMonitor> deadline_;
  std::optional<ActivityMonitor> lease_;  ///< set if the program has to assert liveliness
  std::uint64_t deadlines_missed_ = 0;
  Signs reported_;  ///< the counts of the last sign of life that the readers know of
  Time reported_at_ = Time::min();
};

/// Watches one writer for one of our readers that requests a deadline or a lease.
class RequestMonitor {
 public:
  /// The shortest offered lease that is watched. If a writer offers a shorter lease, the lease that the
  /// reader requests is watched.
  static constexpr std::chrono::milliseconds shortest_offer{10};

  /// `arrived` changes with each sample that arrives.
  RequestMonitor(const Qos& offered, const Qos& requested, std::uint64_t arrived, Time now);

  /// Returns how many deadlines were missed since the previous look.
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
