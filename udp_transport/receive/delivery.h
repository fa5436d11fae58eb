// Puts samples into the inboxes of the readers that requested them: at once, or for reliable readers in the
// order of the channel.
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

/// Must be used by the receiving thread, except where a comment names another thread.
class Delivery {
 public:
  using Time = std::chrono::steady_clock::time_point;
  /// A function that leaves all multicast groups except `groups`, which are IPv4 addresses.
  using KeepGroups = std::function<void(std::span<const std::uint32_t> groups)>;

  /// `reassembly` must outlive this object, which passes the requests of the subscriptions to it.
  Delivery(Reassembly& reassembly, KeepGroups keep_groups)
      : reassembly_(reassembly), keep_groups_(std::move(keep_groups)) {}

  /// Returns the subscriptions. Any thread may use them, except for enter() and leave().
  SubscriptionDirectory& subscriptions() { return subscriptions_; }

  /// Makes the present subscriptions valid until leave(). deliver() may be called only in between.
  void enter();
  void leave() { subscriptions_.leave(); }
  /// Delivers the samples of a datagram. `arrival` must not be empty. Must be called between enter() and
  /// leave().
  void deliver(Arrival& arrival, Time now);

  /// Returns true if some samples wait for earlier samples that may be in the socket for groups. They wait
  /// until the earlier samples have come, or until end_hand_over() is called because that socket is empty.
  bool hands_over() const noexcept { return hand_over_.is_under_way(); }
  void end_hand_over() noexcept;

  /// Retries delivery to reliable readers whose inboxes were full before.
  void look_after_readers(Time now);
  /// Returns the time at which look_after_readers() should be called; Time::max() if no reader lags.
  Time next_look() const { return lag_monitor_.next_look(); }
  /// Returns true if samples have come that wait because the inboxes of their readers are full. Any thread
  /// may call this.
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
  std::vector<core::SampleHandle> batch_;  ///< the samples that are being put into one inbox
};

}  // namespace sft::udp
