// Hands samples to the inboxes of the readers that requested them: at once, or in order for reliable
// readers.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "udp_transport/receive/hand_over.h"
#include "udp_transport/receive/lag_monitor.h"
#include "udp_transport/receive/reassembly.h"
#include "udp_transport/receive/subscriptions.h"

namespace sft::udp {

/// Used by the receiving thread, except where a comment names another thread.
class Delivery {
 public:
  using Time = std::chrono::steady_clock::time_point;
  /// A function that leaves all multicast groups except `groups`, which are IPv4 addresses.
  using KeepGroups = std::function<void(std::span<const std::uint32_t> groups)>;

  /// The reassembly must outlive the delivery, which passes the requests of the subscriptions to it.
  Delivery(Reassembly& reassembly, KeepGroups keep_groups)
      : reassembly_(reassembly), keep_groups_(std::move(keep_groups)) {}

  /// Returns the subscriptions. Any thread may use them, except for enter() and leave().
  SubscriptionDirectory& subscriptions() { return subscriptions_; }

  /// Allows datagrams for the present subscribers until leave().
  void enter();
  void leave() { subscriptions_.leave(); }
  /// Delivers the samples of a datagram. `arrival` must not be empty. Called between enter() and leave().
  void deliver(Arrival& arrival, Time now);

  /// Returns true if some samples wait for earlier ones that may be in the socket of groups. They wait
  /// until these have come, or until end_hand_over() is called because there are none.
  bool hands_over() const noexcept { return hand_over_.is_under_way(); }
  void end_hand_over() noexcept;

  /// Retries delivery to readers that had no room before.
  void look_after_readers(Time now);
  /// Returns when look_after_readers() is due; Time::max() if no reader lags.
  Time next_look() const { return lag_monitor_.next_look(); }
  /// Returns true if some readers have no room for samples that have come. Any thread may call this.
  bool readers_lag() const noexcept { return readers_lag_.load(std::memory_order_relaxed); }

 private:
  void deliver_at_once(Arrival& arrival);
  void hand_over(Arrival& arrival, core::EndpointId writer);
  void go_on_with(HandOver::Waiting waiting);
  bool deliver_in_order(core::EndpointId writer, Time now);
  bool deliver_next(core::EndpointId writer, Time now);
  bool deliver_to(const Subscriber& subscriber, const Stream& stream, ArrivalWindow& window);
  void follow_readers(std::size_t stream_index);
  std::optional<std::size_t> index_of(core::EndpointId writer) const;

  Reassembly& reassembly_;
  const KeepGroups keep_groups_;
  SubscriptionDirectory subscriptions_;
  std::shared_ptr<const Subscriptions> wanted_;  ///< the subscriptions that the reassembly follows
  HandOver hand_over_;
  LagMonitor lag_monitor_;
  std::atomic<bool> readers_lag_{false};
  std::vector<core::SampleHandle> batch_;  ///< samples on their way to one inbox
};

}  // namespace sft::udp
