// The threads that wait until a channel can keep one more sample without giving up an older one. The
// publisher's thread sleeps. The sending thread continues with other work and is notified. All functions
// must be called with the lock of the channel.
#pragma once

#include <chrono>
#include <utility>

#include "core/sync/mutex.h"
#include "udp_transport/outgoing/wake.h"

namespace sft::udp {

class RoomWaiters {
 public:
  /// Waits until the channel may be able to keep a sample. Returns false if `time` has come before. The
  /// publisher calls this function in a loop. `lock` is the lock of the channel, which is released during
  /// the wait.
  bool wait_until(core::Lock& lock, std::chrono::steady_clock::time_point time) {
    publisher_waits_ = true;
    const bool in_time = may_have_room_.wait_until(lock, time);
    publisher_waits_ = false;
    return in_time;
  }
  /// Sets whether the sending thread has a job that waits for this channel.
  void note_sending_thread(bool waits) { sending_thread_waits_ = waits; }

  /// Notes that the channel keeps fewer samples than before. Returns Wake::look if the sending thread waits
  /// for that.
  [[nodiscard]] Wake notify() {
    if (publisher_waits_) may_have_room_.notify_one();
    return std::exchange(sending_thread_waits_, false) ? Wake::look : Wake::none;
  }
  /// Wakes the publisher's thread. Called when the channel has ended.
  void release_publisher() { may_have_room_.notify_all(); }

 private:
  core::Condition may_have_room_;
  bool publisher_waits_ = false;
  bool sending_thread_waits_ = false;
};

}  // namespace sft::udp
