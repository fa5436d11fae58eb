// When this node says that it lives, and what goes with that: which of its writers live, how far they are,
// and what the node asks and answers about accounts. The agent's.
#pragma once

#include <chrono>
#include <vector>

#include "core/control/control.h"
#include "core/discovery/discovery.h"
#include "core/node/account_desk.h"
#include "core/node/local_endpoints.h"
#include "core/platform/clock.h"
#include "core/platform/turns.h"

namespace sft::core {

class OwnLife {
 public:
  OwnLife(NodeId id, const LifeSigns& signs) : id_(id), signs_(signs) {}

  /// True if the last sign of life is a pause ago. In calm the pause is longer, unless signs tell of
  /// accounts.
  bool is_sign_due(bool is_calm, Time now) const { return now >= next(is_calm, now); }
  /// The time until the next sign. It is not a tick later: a node that says nothing for a little longer than
  /// the pause in calm counts as silent.
  std::chrono::milliseconds until_next(bool is_calm, Time now) const {
    return std::chrono::ceil<std::chrono::milliseconds>(next(is_calm, now) - now);
  }
  /// A sign of life is due at once, or soon if another newcomer has just been given one: where many nodes
  /// start, one sign serves several. Without it a newcomer would not notice the end of this node.
  void newcomer_seen() { has_newcomer_ = true; }

  /// The next sign of life, which then counts as told. `living`: writers whose readers wait for that.
  /// `met_at`: as of Discovery. Progress is told again to who may not have heard it.
  Assertion next_sign(std::vector<EndpointId> living, LocalEndpoints& ours, AccountDesk& accounts,
                      Time met_at, Time now);

 private:
  static constexpr std::chrono::seconds tells_accounts_for{3};
  static constexpr std::chrono::milliseconds newcomers_pause{500};

  Time next(bool is_calm, Time now) const {
    const Time in_turn = told_at_ + pause(is_calm, now);
    return has_newcomer_ ? std::min(in_turn, newcomers_told_at_ + newcomers_pause) : in_turn;
  }
  std::chrono::milliseconds pause(bool is_calm, Time now) const {
    const bool is_long = is_calm && now - accounts_told_at_ >= tells_accounts_for;
    return is_long ? signs_.pause_in_calm : signs_.pause;
  }
  std::vector<Progress> take_progress(LocalEndpoints& ours, bool again);

  const NodeId id_;
  const LifeSigns signs_;
  Time told_at_{};
  bool has_newcomer_ = false;  ///< no sign was given since it came
  Time newcomers_told_at_{};
  Time told_more_at_{};  ///< when something else than life was told last
  Time accounts_told_at_{};
  Turns<EndpointId> progress_turns_;
};

}  // namespace sft::core
