// One writer of this node. It brings its ports to the state that the negotiation wants, opens its port in
// shared memory and repeats this if it fails, sends retained samples to late readers, and watches its
// deadline and its liveliness. Used by the agent only.
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
  /// `node` must outlive this object. `endpoint` is the endpoint that is added to the negotiation.
  LocalWriter(NodeContext& node, const Endpoint& endpoint, std::shared_ptr<PublisherCore> core);

  const PublisherCore& core() const { return *core_; }

  // Some functions return true if they have changed the negotiation's table. The negotiation must then be
  // asked again for the desired states.

  /// Brings the writer to its desired state.
  void reconcile();
  /// Tries again to serve readers in shared memory whose doorbells could not be rung, since the obstacle may
  /// have disappeared.
  bool look_after_reach(Time now);
  /// Sends retained samples to late readers. A reader that got the retained samples by UDP may change over
  /// to shared memory one tick after all of these samples have left this process.
  bool look_after_history();
  /// Gives up the port in shared memory, because the memory is lost or belongs to another daemon. Returns
  /// true if the negotiation must be asked again.
  bool drop_memory();
  /// Returns a number that changes when samples are sent in shared memory.
  std::uint64_t sent_in_memory() const;
  /// Returns true if a late reader has not been sent all retained samples yet.
  bool owes_history() const { return in_force_ && in_force_->history_owed; }
  /// Returns true if the opening of a port has failed and may be tried again. Watches readers of DDS.
  bool may_try_again(Time now) {
    const bool may_serve_vanilla = vanilla_.look(now);
    return node_.attempts.may_retry_in_memory(opening_memory_, now) || may_serve_vanilla;
  }

  /// Watches the deadline and the liveliness of the publisher. Returns true if a report must now tell the
  /// readers that the publisher is alive.
  bool watch_promises(Time now);
  /// Returns the time until watch_promises() must be called again, or nothing if neither a deadline nor
  /// liveliness has to be watched.
  std::optional<std::chrono::nanoseconds> pace() const { return monitor_.pace(); }
  /// Returns the progress of the writer. The same progress is returned only a few times, which is more than
  /// once because reports may be lost. After that the function returns nothing until there is new progress.
  /// It also returns nothing if the writer has no readers. `again`: some node might not have received the
  /// last progress.
  std::optional<Progress> take_progress(bool again);

  /// Reports events to the user.
  void report_events();

  /// Returns the readers that match. Accounts are kept of these readers.
  std::vector<EndpointId> matching_readers() const;
  DomainSnapshot::Sent account_of(EndpointId reader) const;

 private:
  bool open_memory(bool wanted);
  Serving desired(Time now) const;
  Serving reachable(Serving wanted, Time now);
  std::string why_not_open() const;
  bool reach_all_again();
  void forget_unreached_but(const Serving& wanted);
  bool is_served_already(const Route& route) const;
  bool has_readers() const {
    return in_force_ && (!in_force_->memory.empty() || !in_force_->network.empty());
  }
  void cannot_reach(const Route& route, const std::string& why_not, Time now);

  NodeContext& node_;
  EndpointId id_;
  std::shared_ptr<PublisherCore> core_;
  std::shared_ptr<LendingWriter> memory_;
  Retry opening_memory_;
  VanillaServing vanilla_;
  std::optional<Serving> in_force_;
  OfferMonitor monitor_;
  std::set<EndpointId> history_sent_;     ///< late readers to which all retained samples had been sent at the
                                          ///< last tick
  std::uint64_t progress_reported_ = 0;   ///< the number of samples published at the last new progress
  int progress_left_ = 0;                 ///< the number of reports that must still contain this progress
  PublisherStatus reported_;              ///< the state that the last reported events led to
  bool has_changes_ = false;              ///< the state may differ from reported_
  std::map<EndpointId, Retry> reaching_;  ///< readers whose doorbells could not be rung, each with its next
                                          ///< attempt
};

}  // namespace sft::core
