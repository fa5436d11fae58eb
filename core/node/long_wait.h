// Detects long waits for a callback: of a sample of one subscriber for its turn, or of the receiving thread
// for the callback that it runs. The class uses no clock: observations and times are passed in, decisions are
// returned.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <utility>

#include "core/platform/clock.h"

namespace sft::core {

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

}  // namespace sft::core
