// What this node tells beside what it announces, and when: which of its writers live, how far they are, and
// what the node asks and answers about accounts. The agent's.
#pragma once

#include <chrono>
#include <vector>

#include "core/control/control.h"
#include "core/node/account_desk.h"
#include "core/node/local_endpoints.h"
#include "core/platform/clock.h"
#include "core/platform/turns.h"

namespace sft::core {

class OwnLife {
 public:
  explicit OwnLife(NodeId id) : id_(id) {}

  /// True if the last sign is a pause ago.
  bool is_sign_due(Time now) const { return now >= told_at_ + pause; }
  /// What has to be told now, which then counts as told; it may be nothing. `living`: writers whose readers
  /// wait for that. `newcomer_at`: as of Discovery. Progress is told again to newcomers.
  Assertion next_sign(std::vector<EndpointId> living, LocalEndpoints& ours, AccountDesk& accounts,
                      Time newcomer_at, Time now);

 private:
  static constexpr std::chrono::milliseconds pause{900};

  std::vector<Progress> take_progress(LocalEndpoints& ours, bool again);

  const NodeId id_;
  Time told_at_{};  ///< when something else than the life of writers was told last
  Turns<EndpointId> progress_turns_;
};

}  // namespace sft::core
