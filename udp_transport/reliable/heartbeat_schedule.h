// Decides when a channel's next heartbeat is due (reliability.md): soon after the last sample, but seldom
// while nothing gets lost, and ever more seldom while nobody answers. Pure.
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

  // `kept` is what is kept by then.

  /// A sample has left, or, if it is not new, a part of one that was sent before.
  void sent(bool is_new, Kept kept, Time now);
  /// The other end has answered.
  void answered(Kept kept, Time now);
  /// The other end misses something that was sent.
  void lost(Time now) { lost_at_ = now; }
  /// The other end does not know something that only a heartbeat tells. The next plan heeds that.
  void want() { is_wanted_ = true; }
  /// Has a heartbeat sent as soon as may be.
  void want_soon(Kept kept, Time now) {
    want();
    plan(kept, now);
  }
  /// The way to the other end is another one: asks at once, if anything is kept.
  void way_changed(Kept kept, Time now);

  /// Returns true if a heartbeat is due; it counts as sent.
  bool take(Kept kept, Time now);
  /// The time to look again, if nothing happens until then; Time::max() if never.
  Time next() const { return next_; }
  /// Heartbeats since the last answer.
  int unanswered() const { return unanswered_; }

 private:
  void plan(Kept kept, Time now);
  void learn_pause(Time::duration pause);
  Time end_of_usual_pause() const;

  const ResendLimits limits_;
  Time sample_at_{};              ///< when something left last
  Time::duration usual_pause_{};  ///< between samples
  Time heartbeat_at_{};           ///< the last one
  Time paid_until_{};             ///< each heartbeat costs a heartbeat_pause
  std::optional<Time> lost_at_;
  int unanswered_ = 0;
  bool is_wanted_ = false;
  Time next_ = Time::max();
};

}  // namespace sft::udp
