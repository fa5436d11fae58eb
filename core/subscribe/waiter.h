// Waits for samples of one subscriber, by any of its ports: looks for them for a while if that has paid
// lately, and then sleeps on the subscriber's doorbell or file descriptor. Keeps the file descriptor readable
// exactly while there is a sample, and after an interrupt. Any thread.
#pragma once

#include <atomic>
#include <chrono>
#include <utility>
#include <vector>

#include "core/platform/clock.h"
#include "core/platform/doorbell.h"
#include "core/platform/poll_handle.h"
#include "core/subscribe/subscriber_ports.h"
#include "core/sync/spin_choice.h"

namespace sft::core {

class Waiter {
 public:
  /// `handle` is null if the subscriber has no file descriptor, and `interrupted` if nothing interrupts it.
  /// All outlive this object. Whoever sets `interrupted` rings the doorbell afterwards.
  Waiter(std::vector<SubscriberPorts*> ports, Doorbell& bell, PollHandle* handle,
         std::chrono::nanoseconds spin, const std::atomic<bool>* interrupted = nullptr)
      : ports_(std::move(ports)), bell_(bell), handle_(handle), interrupted_(interrupted), spin_(spin) {}

  /// True if there is a sample.
  bool available() const;
  bool has_descriptor() const { return handle_ != nullptr; }
  /// -1 if there is none.
  int descriptor() const { return handle_ == nullptr ? -1 : handle_->descriptor(); }

  /// Returns true once there is a sample, and false at the deadline or after an interrupt.
  bool wait_until(Time deadline);
  /// Wakes every thread that sleeps. A thread that receives for its node does not sleep: it has samples by
  /// UDP alone, and finds them itself.
  void wake() { bell_.ring(); }
  /// A sample has arrived: wakes a thread that sleeps.
  void sample_arrived();

  // With a file descriptor.
  /// True if there is a sample, or an interrupt, that the file descriptor does not show.
  bool has_unshown() const { return must_return() && !handle_->is_raised(); }
  void show_if_available();
  /// After samples were taken: the file descriptor is not readable any more if those were all.
  void settle();

 private:
  bool is_interrupted() const {
    return interrupted_ != nullptr && interrupted_->load(std::memory_order_seq_cst);
  }
  bool must_return() const { return available() || is_interrupted(); }
  void sleep_until(Time deadline);
  std::shared_ptr<NetworkReader> receiver() const;

  const std::vector<SubscriberPorts*> ports_;
  Doorbell& bell_;
  PollHandle* const handle_;
  const std::atomic<bool>* const interrupted_;
  const std::chrono::nanoseconds spin_;
  // Two programs that answer each other, and sleep meanwhile, wait for two threads to be woken on two hosts.
  // They have to find out that spinning would spare them that, so ten times the limit is a short wait.
  SpinChoice spinning_{10};
};

}  // namespace sft::core
