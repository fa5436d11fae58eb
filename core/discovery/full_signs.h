// Decides which signs of life have to go by Cyclone, and for which a pulse will do (pulse.h). Pure.
#pragma once

#include <chrono>
#include <map>

#include "core/control/control.h"
#include "core/discovery/life_signs.h"
#include "core/platform/clock.h"

namespace sft::core {

class FullSigns {
 public:
  /// True if a pulse will not do: where discovery is not calm, where the sign tells more than life, for a
  /// while after a newcomer came, which believes no pulse of a node before it has heard a full sign, and if
  /// the last full sign is so long ago that Cyclone has to hear of the node again. The sign is then given.
  bool is_due(const Assertion& sign, bool is_calm, Time newcomer_at, Time now) {
    Time& given_at = given_at_[sign.node];
    const bool may_be_pulse = is_calm && !sign.tells_more_than_life() && now - newcomer_at > newcomers_last &&
                              now - given_at < full_sign_pause;
    if (!may_be_pulse) given_at = now;
    return !may_be_pulse;
  }
  void forget(NodeId node) { given_at_.erase(node); }

 private:
  static constexpr std::chrono::seconds newcomers_last{3};

  std::map<NodeId, Time> given_at_;
};

}  // namespace sft::core
