// Watches the callback of one subscriber: whether it takes long, and whether it has to wait long for
// callbacks of other subscribers of the node. Used by the agent only.
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <utility>

#include "core/platform/clock.h"
#include "core/subscribe/subscriber_core.h"

namespace sft::core {

/// Detects long waits for a callback. Uses no clock: observations and times are passed in.
class LongWait {
 public:
  static constexpr std::chrono::seconds is_long{1};

  /// Returns the duration of the present wait once, when the wait has become long; otherwise returns
  /// nothing. `waits`: a sample or the receiving thread is waiting for the callback now. `turns` must
  /// change with each call of the callback; a change ends an earlier wait.
  std::optional<Time::duration> look(bool waits, std::uint64_t turns, Time now) {
    const bool had_turn = std::exchange(turns_, turns) != turns;
    if (!waits || had_turn || !since_) {
      since_ = waits ? std::optional(now) : std::nullopt;
      is_reported_ = false;
    }
    if (!waits || is_reported_ || now - *since_ < is_long) return std::nullopt;
    is_reported_ = true;
    return now - *since_;
  }
  bool is_under_way() const { return since_.has_value(); }

 private:
  std::uint64_t turns_ = 0;
  std::optional<Time> since_{};
  bool is_reported_ = false;
};

class CallbackMonitor {
 public:
  explicit CallbackMonitor(std::shared_ptr<SubscriberCore> core) : core_(std::move(core)) {}

  struct LongWaits {
    /// Not empty: a sample has waited for its callback for this time.
    std::optional<Time::duration> of_sample;
    /// Not empty: the receiving thread has waited for a callback for this time.
    std::optional<Time::duration> of_receiver;
  };
  /// Returns the waits that have become long since the last call. Each long wait is returned once. Long waits
  /// of samples are counted.
  LongWaits look(Time now);
  /// Returns true if a sample waits for the callback. Then look() should be called soon, because the wait
  /// may become long.
  bool has_waiting_sample() const { return of_sample_.is_under_way(); }
  /// Returns true if a callback was running at the last look and at several looks directly before it.
  bool is_in_long_callback();

 private:
  const std::shared_ptr<SubscriberCore> core_;
  LongWait of_sample_, of_receiver_;
  int looks_in_callback_ = 0;  ///< the number of the latest looks in a row at which a callback was running
};

}  // namespace sft::core
