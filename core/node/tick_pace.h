// Decides how often a node looks after what does not tell of itself, like connections in shared memory and
// calls that were tried in vain. A look costs a wake-up and some calls of the system, which is most of what
// an idle node costs. So looks are frequent while something happens that they may be needed for, and become
// rarer afterwards. Discovery and transports say themselves when they have to be looked after earlier. Pure.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <optional>
#include <utility>

#include "core/platform/clock.h"
#include "core/seam/transport.h"

namespace sft::core {

class TickPace {
 public:
  static constexpr std::chrono::milliseconds pause{50};
  /// So a look goes together with a heartbeat, which is given each second.
  static constexpr std::chrono::milliseconds pause_when_quiet{932};
  static_assert(pause_when_quiet <= Transport::poll_pause_max);

  /// Something happens that has to be looked after.
  void stirred(Time now) { stirred_ = now; }
  /// `samples` differs from what it was if samples have gone by shared memory meanwhile. Nothing else tells
  /// that a daemon has ended, or that a sample is held back for another one that was sent by UDP.
  void note_traffic(std::uint64_t samples, Time now) {
    if (std::exchange(samples_, samples) != samples) stirred(now);
  }
  /// Returns the time until the next look, which grows with the time for which nothing has happened.
  std::chrono::milliseconds next(Time now) const {
    if (!stirred_) return pause_when_quiet;
    const auto half = std::chrono::duration_cast<std::chrono::milliseconds>((now - *stirred_) / 2);
    return std::clamp(half, pause, pause_when_quiet);
  }

 private:
  std::optional<Time> stirred_{};
  std::uint64_t samples_ = 0;
};

}  // namespace sft::core
