// Decides how often a node looks after what does not tell of itself, like connections in shared memory and
// calls that were tried in vain. A look costs a wake-up and some calls of the system, which is most of what
// an idle node costs. So looks are frequent while something happens that they may be needed for, and for a
// while afterwards, and seldom otherwise: also where discovery is not calm, since what it waits for comes
// once or twice in a second. Pure.
#pragma once

#include <chrono>
#include <optional>

#include "core/platform/clock.h"

namespace sft::core {

class TickPace {
 public:
  static constexpr std::chrono::milliseconds pause{50};
  static constexpr std::chrono::milliseconds pause_in_calm{200};
  static constexpr std::chrono::seconds calm_after{2};

  /// Something happens that has to be looked after.
  void stirred(Time now) { stirred_ = now; }
  /// Returns the time until the next look.
  std::chrono::milliseconds next(Time now) const {
    return stirred_ && now - *stirred_ < calm_after ? pause : pause_in_calm;
  }

 private:
  std::optional<Time> stirred_{};
};

}  // namespace sft::core
