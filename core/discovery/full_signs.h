// Decides which signs of life have to go by Cyclone, and for which a pulse will do (pulse.h). Pure.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <map>

#include "core/control/control.h"
#include "core/discovery/crowd.h"
#include "core/discovery/life_signs.h"
#include "core/platform/clock.h"

namespace sft::core {

/// Returns when full signs begin to go and come on a link where there are pulses. Their reader and writer
/// meet those of everybody, which is half of what a newcomer costs each of the others. So they wait until
/// nobody has met anybody for a while: where many nodes start, all announcements arrive first. `opened_at`:
/// the link; `met_at`: when control endpoints met last, ours and somebody else's; `participants`: those that
/// are known, of which some may be made up.
constexpr Time full_signs_begin_at(Time opened_at, Time met_at, std::size_t participants) {
  using namespace std::chrono_literals;
  return std::min(std::max(opened_at, met_at) + 80ms + for_others(40ms, participants),
                  opened_at + 2s + for_others(60ms, participants));
}

class FullSigns {
 public:
  /// True if a pulse will not do: where somebody wants frequent signs, since pulses may not arrive; where the
  /// sign tells more than life; now and then for a while after a newcomer was met, which has yet to see that
  /// full signs arrive; and if the last full sign is so long ago that Cyclone has to hear of the node again.
  /// The sign is then given. News of this process are no reason: pulses tell the digests, too.
  bool is_due(const Assertion& sign, bool is_wanted, Time newcomer_at, Time now) {
    Time& given_at = given_at_[sign.node];
    const bool is_full =
        is_wanted || sign.tells_more_than_life() || now - given_at >= pause(now - newcomer_at);
    if (is_full) given_at = now;
    return is_full;
  }
  void forget(NodeId node) { given_at_.erase(node); }
  /// The next sign of each node is a full one: there is a link on which none was given yet.
  void begin_anew() { given_at_.clear(); }

 private:
  /// Each of these signs wakes everybody, and a crowd of newcomers is busy with finding each other: some are
  /// not heard, and one is given after that. Who has missed all of them asks for more (HearingWatch).
  static constexpr std::chrono::milliseconds pause(Time::duration since_newcomer) {
    using namespace std::chrono_literals;
    if (since_newcomer <= 3s) return 1200ms;
    return since_newcomer <= 8s ? 3000ms : full_sign_pause;
  }

  std::map<NodeId, Time> given_at_;
};

}  // namespace sft::core
