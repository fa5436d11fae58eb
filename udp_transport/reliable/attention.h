// Tracks whether the sending thread maintains a channel, and when the thread checks the channel next. So the
// thread is woken only for events that it would notice too late. Uses no clock, thread or I/O.
#pragma once

#include <chrono>
#include <utility>

#include "udp_transport/outgoing/wake.h"

namespace sft::udp {

class Attention {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// Returns true if the sending thread maintains the channel: after attract(), until rest().
  bool is_paid() const { return is_paid_; }
  /// Notes that the channel needs the sending thread. Returns Wake::schedule if the thread does not maintain
  /// it yet.
  [[nodiscard]] Wake attract() {
    if (std::exchange(is_paid_, true)) return Wake::none;
    looks_at_ = {};  // the first check is due at once
    return Wake::schedule;
  }
  /// Notes that the channel has data to send. Returns Wake::look for the first call after a check, and
  /// Wake::none for further calls.
  [[nodiscard]] Wake wake() { return std::exchange(is_woken_, true) ? Wake::none : Wake::look; }
  /// Notes that the channel has to be checked at the time `due`. Returns Wake::look if the sending thread's
  /// next check is later.
  [[nodiscard]] Wake look_by(Time due, Time now) {
    if (due >= looks_at_) return Wake::none;
    looks_at_ = now;
    return Wake::look;
  }

  // The following functions are for the sending thread.

  /// Notes that the sending thread now checks the channel for data to send.
  void looks() { is_woken_ = false; }
  /// Notes that the sending thread has maintained the channel, and will maintain it again at that time or
  /// earlier.
  void looks_again_by(Time time) { looks_at_ = time; }
  /// Notes that the sending thread does not maintain the channel any more.
  void rest() { is_paid_ = false; }

 private:
  bool is_paid_ = false;
  bool is_woken_ = false;
  Time looks_at_ = Time::max();
};

}  // namespace sft::udp
