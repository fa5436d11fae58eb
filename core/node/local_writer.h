// One writer of this node: brings its ports to the state that the negotiation wants, opens its port in shared
// memory and tries again if that fails, gives retained samples to late readers, and watches its promises.
// Used by the agent only.
#pragma once

#include <chrono>
#include <cstdint>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <vector>

#include "core/negotiation/qos_monitor.h"
#include "core/node/node_context.h"
#include "core/node/vanilla_serving.h"
#include "core/platform/clock.h"
#include "core/publish/publisher_core.h"

namespace sft::core {

class LocalWriter {
 public:
  /// `node` outlives this object. `endpoint` is the one that is added to the negotiation.
  LocalWriter(NodeContext& node, const Endpoint& endpoint, std::shared_ptr<PublisherCore> core);

  const PublisherCore& core() const { return *core_; }

  // Functions that return true have changed the negotiation's table: it must be asked for the desired states
  // again.

  /// Brings the writer to its desired state.
  void reconcile();
  /// Tries again to serve readers in shared memory whose doorbells could not be rung: the obstacle may be
  /// gone.
  bool look_after_reach(Time now);
  /// Gives retained samples to late readers. A reader may change over to shared memory one tick after all its
  /// samples by UDP have left.
  bool look_after_history();
  /// Gives up the port in shared memory, because the memory is gone, or is another daemon's.
  bool drop_memory();
  /// Returns a number that changes when samples are sent in shared memory.
  std::uint64_t sent_in_memory() const;
  /// Returns true if a late reader has not got all retained samples yet.
  bool owes_history() const { return in_force_ && in_force_->history_owed; }
  /// Returns true if the port could not be opened and may be tried again.
  bool may_try_again(Time now) const {
    return node_.attempts.may_retry_in_memory(opening_memory_, now) || vanilla_.may_try_again(now);
  }

  /// Watches the promises of the publisher. Returns true if its readers must be told now that it is alive.
  bool watch_promises(Time now);
  /// Returns how long the next look can wait; nothing if no promise has to be watched.
  std::optional<std::chrono::nanoseconds> pace() const { return monitor_.pace(); }
  /// Returns the progress of the writer: each progress a few times, because reports may get lost. Returns
  /// nothing after that, or if the writer has no readers. `again`: some reader may not have received the last
  /// progress.
  std::optional<Progress> take_progress(bool again);

  /// Reports events to the user.
  void report_events();

  /// Returns the readers that match. Each has an account.
  std::vector<EndpointId> matching_readers() const;
  Account::OfWriter account_of(EndpointId reader) const;

 private:
  bool open_memory(bool wanted);
  Serving reachable(Serving wanted);
  std::string why_not_open() const;
  bool reach_all_again();
  void forget_unreached_but(const Serving& wanted);
  bool is_served_already(const Route& route) const;
  bool has_readers() const {
    return in_force_ && (!in_force_->memory.empty() || !in_force_->network.empty());
  }
  void cannot_reach(const Route& route, const std::string& why_not);

  NodeContext& node_;
  EndpointId id_;
  std::shared_ptr<PublisherCore> core_;
  std::shared_ptr<LendingWriter> memory_;
  Retry opening_memory_;
  VanillaServing vanilla_;
  std::optional<Serving> in_force_;
  OfferMonitor monitor_;
  std::set<EndpointId> history_sent_;     ///< late readers that had been sent everything at the last tick
  std::uint64_t progress_reported_ = 0;   ///< samples published at the last new progress
  int progress_left_ = 0;                 ///< how often that must still be reported
  PublisherStatus reported_;              ///< the state up to which events were reported
  bool has_changes_ = false;              ///< the state may differ from reported_
  std::map<EndpointId, Retry> reaching_;  ///< readers whose doorbells could not be rung
};

}  // namespace sft::core
