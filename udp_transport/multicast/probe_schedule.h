// Decides when a writer sends probes to a multicast group. Probes come soon after an offer of the group, so
// that members report before the next sample. Uses no clock, thread or I/O.
#pragma once

#include <chrono>

namespace sft::udp {

class ProbeSchedule {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// The pause from an offer to the first probe. It suffices for a member that reads the offer and joins at
  /// once. Each further pause is twice as long, since a busy member reads the offer later, and a switch
  /// needs some time to register a new member.
  static constexpr std::chrono::milliseconds first_pause{2};
  static constexpr int probes_max = 5;

  /// Notes that the group was offered to some members.
  void offered(Time now) {
    left_ = probes_max;
    pause_ = first_pause;
    next_ = now + pause_;
  }
  /// Returns true if a probe is due now, and counts it as sent.
  bool due(Time now) {
    if (now < next_) return false;
    pause_ *= 2;
    next_ = --left_ > 0 ? now + pause_ : Time::max();
    return true;
  }
  /// Stops probing. Called when all members have reported.
  void stop() { next_ = Time::max(); }
  /// Returns the time at which due() will return true; Time::max() if no probe is planned.
  Time next() const { return next_; }

 private:
  int left_ = 0;
  std::chrono::milliseconds pause_ = first_pause;
  Time next_ = Time::max();
};

}  // namespace sft::udp
