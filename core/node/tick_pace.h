// Decides how often a node looks after what does not tell of itself, like connections in shared memory and
// calls that were tried in vain. A look costs a wake-up and some calls of the system, which is most of what
// an idle node costs. So looks are frequent while something happens that they may be needed for, and for a
// while afterwards. They are less frequent where only discovery has something to look after, since that waits
// for others who say something twice in a second, and seldom in calm. Pure.
#pragma once

#include <chrono>
#include <optional>

#include "core/platform/clock.h"

namespace sft::core {

class TickPace {
 public:
  static constexpr std::chrono::milliseconds pause{50};
  static constexpr std::chrono::milliseconds pause_for_discovery{200};
  static constexpr std::chrono::milliseconds pause_in_calm{500};
  static constexpr std::chrono::seconds calm_after{2};

  /// Something happens that has to be looked after.
  void stirred(Time now) { stirred_ = now; }
  /// Returns the time until the next look. `is_calm`: of discovery.
  std::chrono::milliseconds next(bool is_calm, Time now) const {
    if (stirred_ && now - *stirred_ < calm_after) return pause;
    return is_calm ? pause_in_calm : pause_for_discovery;
  }

 private:
  std::optional<Time> stirred_{};
};

}  // namespace sft::core
