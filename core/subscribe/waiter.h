// Waits for samples of one subscriber, by any of its ports: looks for them for a while if that has paid
// lately, and then sleeps on the subscriber's doorbell or file descriptor. Keeps the file descriptor readable
// exactly while there is a sample. Any thread.
#pragma once

#include <chrono>
#include <utility>
#include <vector>

#include "core/platform/clock.h"
#include "core/platform/doorbell.h"
#include "core/platform/poll_handle.h"
#include "core/subscribe/spin_choice.h"
#include "core/subscribe/subscriber_ports.h"

namespace sft::core {

class Waiter {
 public:
  /// `handle` is null if the subscriber has no file descriptor; all others outlive this object.
  Waiter(std::vector<SubscriberPorts*> ports, Doorbell& bell, PollHandle* handle,
         std::chrono::nanoseconds spin)
      : ports_(std::move(ports)), bell_(bell), handle_(handle), spinning_(spin) {}

  /// True if there is a sample.
  bool available() const;
  bool has_descriptor() const { return handle_ != nullptr; }
  /// -1 if there is none.
  int descriptor() const { return handle_ == nullptr ? -1 : handle_->descriptor(); }

  /// Returns true once there is a sample, and false at the deadline.
  bool wait_until(Time deadline);
  /// Wakes every thread that sleeps. A thread that receives for its node does not sleep: it has samples by
  /// UDP alone, and finds them itself.
  void wake() { bell_.ring(); }
  /// A sample has arrived: wakes a thread that sleeps.
  void sample_arrived();

  // With a file descriptor.
  /// True if there is a sample that the file descriptor does not tell of.
  bool has_untold() const { return available() && !handle_->is_raised(); }
  void tell_if_available();
  /// After samples were taken: the file descriptor is not readable any more if those were all.
  void settle();

 private:
  void sleep_until(Time deadline);
  std::shared_ptr<NetworkReader> receiver() const;

  const std::vector<SubscriberPorts*> ports_;
  Doorbell& bell_;
  PollHandle* const handle_;
  SpinChoice spinning_;
};

}  // namespace sft::core
