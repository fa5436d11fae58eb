// When this node says that it lives, and what goes with that: which of its writers live, how far they are,
// and what the node asks and answers about accounts. The agent's.
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
  OwnLife(NodeId id, std::chrono::milliseconds pause) : id_(id), pause_(pause) {}

  /// True if the last sign of life is a pause ago.
  bool is_sign_due(Time now) const { return now - told_at_ >= pause_; }
  /// A sign of life is due at once. Without it a newcomer would not notice the end of this node.
  void newcomer_seen() { told_at_ = {}; }

  /// The next sign of life, which then counts as told. `living`: writers whose readers wait for that.
  Assertion next_sign(std::vector<EndpointId> living, LocalEndpoints& ours, AccountDesk& accounts, Time now);

 private:
  std::vector<Progress> take_progress(LocalEndpoints& ours);

  const NodeId id_;
  const std::chrono::milliseconds pause_;
  Time told_at_{};
  Time told_more_at_{};  ///< when something else than life was told last
  Turns<EndpointId> progress_turns_;
};

}  // namespace sft::core
