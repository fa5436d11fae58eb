// One writer of this node: brings its ports to the state that the negotiation wants, opens its port in shared
// memory and tries again where that fails, looks after its late readers and its promises. The agent's.
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
  /// `node` outlives this object. `endpoint` as it is added to the negotiation.
  LocalWriter(NodeContext& node, const Endpoint& endpoint, std::shared_ptr<PublisherCore> core);

  const PublisherCore& core() const { return *core_; }

  // Functions that return true have changed the negotiation's table: the desired states are to be asked for
  // again.

  /// Brings the writer to its desired state.
  void reconcile();
  /// Asks again for readers that could not be told of samples in shared memory: what stood in the way may be
  /// gone.
  bool look_after_reach(Time now);
  /// Gives retained samples to late readers. A reader may change over to shared memory one tick after all
  /// that it was sent by UDP has left.
  bool look_after_history();
  /// The memory of the port is gone, or another daemon's.
  bool drop_memory();
  /// Differs from what it was if samples have gone by shared memory meanwhile.
  std::uint64_t sent_in_memory() const;
  /// True if some reader is still being given retained samples.
  bool owes_history() const { return in_force_ && in_force_->history_owed; }
  /// True if the port could not be opened and may be tried again.
  bool may_try_again(Time now) const {
    return node_.attempts.may_retry_in_memory(opening_memory_, now) || vanilla_.may_try_again(now);
  }

  /// Looks at what the publisher has promised. True if its readers have to be told now that it lives.
  bool watch_promises(Time now);
  /// How long the next look can wait; nothing if there is nothing to look at.
  std::optional<std::chrono::nanoseconds> pace() const { return monitor_.pace(); }
  /// How far the writer is, a few times, since what tells it may get lost; nothing if it has no readers, or
  /// has sent nothing since. `again`: some reader may not have heard it.
  std::optional<Progress> take_progress(bool again);

  /// Tells the user what has happened.
  void report_events();

  /// The readers that match, each with an account.
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
  std::uint64_t progress_reported_ = 0;   ///< samples published when others were told of the progress last
  int progress_left_ = 0;                 ///< how often that has to be told yet
  PublisherStatus reported_;              ///< the state up to which events were told
  bool has_changes_ = false;              ///< the state may differ from told_
  std::map<EndpointId, Retry> reaching_;  ///< readers in memory that could not be told of samples
};

}  // namespace sft::core
