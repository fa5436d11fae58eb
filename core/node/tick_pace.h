// Decides how often a node checks states that raise no event, such as connections in shared memory and
// failed calls. Such a check (a look) costs a wake-up and some system calls, and looks cause most of the
// cost of an idle node. So looks are frequent while changes are likely, and become rarer afterwards. If
// discovery or a transport needs an earlier look, the caller reduces the result. Uses no clock, thread or
// I/O.
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
  static constexpr std::chrono::milliseconds pause_while_attaching{1};
  static constexpr int hurried_looks_max = 1000;  ///< a connection that takes longer is checked less often
  /// With this pause, a look coincides with a heartbeat, which is sent once a second.
  static constexpr std::chrono::milliseconds pause_when_quiet{932};
  static_assert(pause_when_quiet <= Transport::poll_pause_max);

  /// Called when something happens that requires frequent looks.
  void stirred(Time now) { stirred_ = now; }
  /// `samples` must change whenever samples are sent or received in shared memory. Then frequent looks are
  /// needed, because two situations raise no event: the daemon has ended, or a sample is held back until an
  /// earlier sample that was sent by UDP arrives.
  void note_traffic(std::uint64_t samples, Time now) {
    if (std::exchange(samples_, samples) != samples) stirred(now);
  }
  /// Called at each look. `waits`: some reader waits for its connection in shared memory.
  void note_waiting(bool waits) { hurried_looks_ = waits ? hurried_looks_ + 1 : 0; }
  /// Returns the time until the next look. This time grows with the time since the last call of stirred().
  std::chrono::milliseconds next(Time now) const {
    if (hurried_looks_ > 0 && hurried_looks_ <= hurried_looks_max) return pause_while_attaching;
    if (!stirred_) return pause_when_quiet;
    const auto half = std::chrono::duration_cast<std::chrono::milliseconds>((now - *stirred_) / 2);
    return std::clamp(half, pause, pause_when_quiet);
  }

 private:
  std::optional<Time> stirred_{};
  std::uint64_t samples_ = 0;
  int hurried_looks_ = 0;  ///< the number of successive looks at which some reader waited
};

}  // namespace sft::core
