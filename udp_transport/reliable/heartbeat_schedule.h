// Decides when a channel's next heartbeat is due (reliability.md): soon after the last sample, but rarely
// while nothing is lost, and ever more rarely while no answer comes. Uses no clock, thread or I/O.
#pragma once

#include <chrono>
#include <optional>

#include "udp_transport/reliable/kept_samples.h"
#include "udp_transport/reliable/resend_limits.h"

namespace sft::udp {

class HeartbeatSchedule {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Kept = KeptSamples::Amount;

  explicit HeartbeatSchedule(const ResendLimits& limits) : limits_(limits) {}

  // `kept` is the amount that the channel keeps at that time.

  /// Notes that a sample was sent or, if it is not new, a part of a sample was sent again.
  void sent(bool is_new, Kept kept, Time now);
  /// Notes that the receiver has answered.
  void answered(Kept kept, Time now);
  /// Notes that the receiver misses something that was sent.
  void lost(Time now) { lost_at_ = now; }
  /// Notes that the receiver needs something that only a heartbeat tells. The next plan takes that into
  /// account.
  void want() { is_wanted_ = true; }
  /// Sends a heartbeat as soon as possible.
  void want_soon(Kept kept, Time now) {
    want();
    plan(kept, now);
  }
  /// Notes that the path to the receiver has changed. A heartbeat is due at once if anything is kept.
  void way_changed(Kept kept, Time now);

  /// Returns true if a heartbeat is due; it counts as sent.
  bool take(Kept kept, Time now);
  /// Returns the time of the next check, if nothing happens until then; Time::max() if never.
  Time next() const { return next_; }
  /// Returns the number of heartbeats since the last answer.
  int unanswered() const { return unanswered_; }

 private:
  void plan(Kept kept, Time now);
  void learn_pause(Time::duration pause);
  Time end_of_usual_pause() const;

  const ResendLimits limits_;
  Time sample_at_{};              ///< when a sample, or a part of one, was sent last
  Time::duration usual_pause_{};  ///< usual pause between samples
  Time heartbeat_at_{};           ///< when the last heartbeat was sent
  Time paid_until_{};             ///< each heartbeat adds a `heartbeat_pause` to this
  std::optional<Time> lost_at_;
  int unanswered_ = 0;
  bool is_wanted_ = false;
  Time next_ = Time::max();
};

}  // namespace sft::udp
