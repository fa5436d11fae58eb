// Decides when a channel's next heartbeat is due (reliability.md). A heartbeat is due soon after the last
// sample. Heartbeats are rare while no datagram is lost, and become rarer while the receiver does not
// answer. Uses no clock, thread or I/O.
#pragma once

#include <chrono>
#include <optional>

#include "udp_transport/outgoing/resend_limits.h"
#include "udp_transport/reliable/kept_samples.h"

namespace sft::udp {

class HeartbeatSchedule {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Kept = KeptSamples::Amount;

  explicit HeartbeatSchedule(const ResendLimits& limits) : limits_(limits) {}

  // In the following functions, `kept` is the amount of samples that the channel keeps at that time.

  /// Notes that a sample was sent. If `is_new` is false, a part of a sample was sent again.
  void sent(bool is_new, Kept kept, Time now);
  /// Notes that the receiver has answered.
  void answered(Kept kept, Time now);
  /// Notes that the receiver misses a part of a sample that was sent.
  void lost(Time now) { lost_at_ = now; }
  /// Notes that the receiver needs a heartbeat. The next plan takes that into account.
  void want() { is_wanted_ = true; }
  /// Notes that a heartbeat should be sent as soon as possible.
  void want_soon(Kept kept, Time now) {
    want();
    plan(kept, now);
  }
  /// Notes that the path to the receiver has changed. A heartbeat is due at once if the channel keeps any
  /// sample.
  void way_changed(Kept kept, Time now);

  /// Returns true if a heartbeat is due. Then the heartbeat counts as sent.
  bool take(Kept kept, Time now);
  /// Returns the time of the next check if no event is noted before; Time::max() if no check is needed.
  Time next() const { return next_; }
  /// Returns the number of heartbeats since the last answer.
  int unanswered() const { return unanswered_; }

 private:
  void plan(Kept kept, Time now);
  void learn_pause(Time::duration pause);
  Time end_of_usual_pause() const;

  const ResendLimits limits_;
  Time sample_at_{};              ///< time when a sample, or a repeated part of a sample, was last sent
  Time::duration usual_pause_{};  ///< usual pause between samples
  Time heartbeat_at_{};           ///< time of the last heartbeat
  /// The budget of heartbeats: each heartbeat adds ResendLimits::heartbeat_pause to this time.
  Time paid_until_{};
  std::optional<Time> lost_at_;
  int unanswered_ = 0;
  bool is_wanted_ = false;
  Time next_ = Time::max();
};

}  // namespace sft::udp
