// The threads that wait for room in a channel: the publisher's, which sleeps, and the sending one, which goes
// on with something else and is told. All functions are called with the lock of the channel.
#pragma once

#include <chrono>
#include <utility>

#include "core/sync/mutex.h"
#include "udp_transport/outgoing/wake.h"

namespace sft::udp {

class RoomWaiters {
 public:
  /// The publisher waits, in a loop, until room may have been made. False if the time is over. `lock` is that
  /// of the channel; it is unlocked meanwhile.
  bool wait_until(core::Lock& lock, std::chrono::steady_clock::time_point time) {
    publisher_waits_ = true;
    const bool in_time = may_have_room_.wait_until(lock, time);
    publisher_waits_ = false;
    return in_time;
  }
  /// The sending thread has something that waits for room, or has nothing of that kind any more.
  void note_sending_thread(bool waits) { sending_thread_waits_ = waits; }

  /// Less is kept than before. Wake::look if the sending thread waits for that.
  [[nodiscard]] Wake notify() {
    if (publisher_waits_) may_have_room_.notify_one();
    return std::exchange(sending_thread_waits_, false) ? Wake::look : Wake::none;
  }
  /// The channel has ended: its publisher has to wait no longer.
  void release_publisher() { may_have_room_.notify_all(); }

 private:
  core::Condition may_have_room_;
  bool publisher_waits_ = false;
  bool sending_thread_waits_ = false;
};

}  // namespace sft::udp
