// Decides how often a discovery link may be made anew. A link is made anew if it does not hear a node, or if
// another node complains about it. Pure.
//
// A new link costs work for every node on the network. Therefore the pauses grow if new links do not help. If
// a new link helps for a while and is needed again, somebody may be forging datagrams. Then the pause stays
// shorter than the lease of the signs of life, so that no living node is taken for dead.
#pragma once

#include <algorithm>
#include <chrono>
#include <optional>

#include "core/platform/clock.h"

namespace sft::core {

class RenewalPace {
 public:
  static constexpr std::chrono::milliseconds pause_min{500};
  static constexpr std::chrono::milliseconds pause_max{20'000};
  /// Well below the lease of signs of life (5 s).
  static constexpr std::chrono::milliseconds pause_where_it_helps{2000};
  static constexpr std::chrono::seconds helps_for{1};
  /// After this time without a renewal the pauses begin again with pause_min.
  static constexpr std::chrono::seconds calm_after{120};

  /// Call this when a node is missed or complains. True if the link may be made anew now.
  bool is_needed(Time now) {
    if (!last_ || now - *last_ > calm_after) return true;
    if (!needed_since_) needed_since_ = now;
    const bool helped = *needed_since_ - *last_ >= helps_for;
    return now - *last_ >= (helped ? std::min(pause_, pause_where_it_helps) : pause_);
  }
  /// Call this when the link is made anew, also if that fails.
  void renewed(Time now) {
    const bool is_calm = !last_ || now - *last_ > calm_after;
    pause_ = is_calm ? pause_min : std::min(2 * pause_, pause_max);
    last_ = now;
    needed_since_.reset();
  }

 private:
  std::chrono::milliseconds pause_{pause_min};
  std::optional<Time> last_, needed_since_;
};

}  // namespace sft::core
