// The attention that the sending thread pays to a channel: whether it attends to the channel, and when it
// looks at it next. So it is woken only for what it would not see in time. Pure.
#pragma once

#include <chrono>
#include <utility>

#include "udp_transport/outgoing/wake.h"

namespace sft::udp {

class Attention {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// True from attract() until rest().
  bool is_paid() const { return is_paid_; }
  /// The channel has something to look after. Wake::schedule if the sending thread does not attend to it yet.
  [[nodiscard]] Wake attract() {
    if (std::exchange(is_paid_, true)) return Wake::none;
    looks_at_ = {};  // at once
    return Wake::schedule;
  }
  /// The channel has something to send. Wake::look once until the next look.
  [[nodiscard]] Wake wake() { return std::exchange(is_woken_, true) ? Wake::none : Wake::look; }
  /// Something is due at that time. Wake::look if the sending thread would look later.
  [[nodiscard]] Wake look_by(Time due, Time now) {
    if (due >= looks_at_) return Wake::none;
    looks_at_ = now;
    return Wake::look;
  }

  // The sending thread.

  /// The sending thread looks for something to send.
  void looks() { is_woken_ = false; }
  /// The sending thread has looked after the channel, and does so again by that time.
  void looks_again_by(Time time) { looks_at_ = time; }
  /// The sending thread attends to the channel no more.
  void rest() { is_paid_ = false; }

 private:
  bool is_paid_ = false;
  bool is_woken_ = false;
  Time looks_at_ = Time::max();
};

}  // namespace sft::udp
