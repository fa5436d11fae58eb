// Decides how often a node checks states that raise no event, such as connections in shared memory and failed
// calls. A look costs a wake-up and some system calls, which is most of the cost of an idle node. So looks
// are frequent while they may be needed, and become rarer afterwards. Discovery and transports say if they
// need an earlier look. Uses no clock, thread or I/O.
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
  /// With this pause, a look coincides with a heartbeat, which is sent once a second.
  static constexpr std::chrono::milliseconds pause_when_quiet{932};
  static_assert(pause_when_quiet <= Transport::poll_pause_max);

  /// Called when something happens that requires frequent looks.
  void stirred(Time now) { stirred_ = now; }
  /// `samples` is a number that has changed if samples went by shared memory since the last call. In this
  /// case frequent looks are needed, because two states raise no event: a daemon has ended, or a sample is
  /// held back for another one that was sent by UDP.
  void note_traffic(std::uint64_t samples, Time now) {
    if (std::exchange(samples_, samples) != samples) stirred(now);
  }
  /// Returns the time until the next look. It grows with the time since the last call of stirred().
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
