// Tracks if the sending thread attends to a channel, and when it checks the channel next. So the thread is
// woken only for events that it would not notice in time. Uses no clock, thread or I/O.
#pragma once

#include <chrono>
#include <utility>

#include "udp_transport/outgoing/wake.h"

namespace sft::udp {

class Attention {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// Returns true if the sending thread attends to the channel, which it does from attract() until rest().
  bool is_paid() const { return is_paid_; }
  /// Notes that the channel needs the sending thread. Returns Wake::schedule if the thread does not attend
  /// to it yet.
  [[nodiscard]] Wake attract() {
    if (std::exchange(is_paid_, true)) return Wake::none;
    looks_at_ = {};  // checks at once
    return Wake::schedule;
  }
  /// Notes that the channel has something to send. Returns Wake::look once until the next check.
  [[nodiscard]] Wake wake() { return std::exchange(is_woken_, true) ? Wake::none : Wake::look; }
  /// Notes that something is due at that time. Returns Wake::look if the sending thread's next check is
  /// later.
  [[nodiscard]] Wake look_by(Time due, Time now) {
    if (due >= looks_at_) return Wake::none;
    looks_at_ = now;
    return Wake::look;
  }

  // The following functions are for the sending thread.

  /// Notes that the sending thread checks the channel for something to send.
  void looks() { is_woken_ = false; }
  /// Notes that the sending thread has maintained the channel, and will do so again by that time.
  void looks_again_by(Time time) { looks_at_ = time; }
  /// Notes that the sending thread does not attend to the channel any more.
  void rest() { is_paid_ = false; }

 private:
  bool is_paid_ = false;
  bool is_woken_ = false;
  Time looks_at_ = Time::max();
};

}  // namespace sft::udp
