// How often a link may be made anew that does not hear somebody, or of which somebody complains. Pure.
//
// Making it anew costs all who are on it some work. So it is done ever more seldom where it does not help.
// Where it helps for a while, and is needed again, somebody may be forging what is said on the link: then it
// has to come before anybody is taken for dead for want of signs of life, and the pause stays short.
#pragma once

#include <algorithm>
#include <chrono>
#include <optional>

namespace sft::core {

class RenewalPace {
 public:
  using Now = std::chrono::steady_clock::time_point;
  static constexpr std::chrono::milliseconds pause_min{500};
  static constexpr std::chrono::milliseconds pause_max{20'000};
  /// Well below the lease of signs of life (5 s).
  static constexpr std::chrono::milliseconds pause_where_it_helps{2000};
  static constexpr std::chrono::seconds helps_for{1};
  /// After so long without one, all begins anew.
  static constexpr std::chrono::seconds calm_after{120};

  /// Somebody is missed, or complains. Whether the link may be made anew for that.
  bool is_needed(Now now) {
    if (!last_ || now - *last_ > calm_after) return true;
    if (!needed_since_) needed_since_ = now;
    const bool helped = *needed_since_ - *last_ >= helps_for;
    return now - *last_ >= (helped ? std::min(pause_, pause_where_it_helps) : pause_);
  }
  /// It is made anew, or was tried to be.
  void renewed(Now now) {
    const bool is_calm = !last_ || now - *last_ > calm_after;
    pause_ = is_calm ? pause_min : std::min(2 * pause_, pause_max);
    last_ = now;
    needed_since_.reset();
  }

 private:
  std::chrono::milliseconds pause_{pause_min};
  std::optional<Now> last_, needed_since_;
};

}  // namespace sft::core
