// Waits for samples of one subscriber, by any of its ports. A wait polls for a while if the last wait was
// short, and then sleeps on the subscriber's doorbell or file descriptor. The class keeps the file descriptor
// readable exactly while there is a sample, and after an interrupt, once a program has asked for it. Before
// that, only waits lower it, since that is a system call, which is spared for each take. Any thread.
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
  /// `handle` is null if the subscriber has no file descriptor, and `interrupted` is null if there are no
  /// interrupts. All arguments must outlive this object. The thread that sets `interrupted` must ring the
  /// doorbell afterwards.
  Waiter(std::vector<SubscriberPorts*> ports, Doorbell& bell, PollHandle* handle,
         std::chrono::nanoseconds spin, const std::atomic<bool>* interrupted = nullptr)
      : ports_(std::move(ports)), bell_(bell), handle_(handle), interrupted_(interrupted), spin_(spin) {}

  /// Returns true if there is a sample.
  bool available() const;
  bool has_descriptor() const { return handle_ != nullptr; }
  /// Returns the file descriptor for a program, or -1 if there is none.
  int descriptor() const;

  /// Returns true once there is a sample. Returns false at the deadline or after an interrupt.
  bool wait_until(Time deadline);
  /// Wakes every sleeping thread. A thread that receives for its node does not sleep: its subscriber gets
  /// samples only by UDP, and the thread itself finds them.
  void wake() { bell_.ring(); }
  /// Wakes a sleeping thread because a sample has arrived.
  void sample_arrived();

  // The functions for subscribers with a file descriptor.
  /// Returns true if there is a sample or an interrupt, and the file descriptor is not readable yet.
  bool has_unshown() const { return must_return() && !handle_->is_raised(); }
  void show_if_available() const;
  /// Must be called after samples were taken.
  void taken() const {
    if (is_watched_.load(std::memory_order_seq_cst)) settle();
  }

 private:
  bool is_interrupted() const {
    return interrupted_ != nullptr && interrupted_->load(std::memory_order_seq_cst);
  }
  bool must_return() const { return available() || is_interrupted(); }
  /// Makes the file descriptor unreadable if there are no samples.
  void settle() const;
  void sleep_until(Time deadline);
  std::shared_ptr<NetworkReader> receiver() const;

  const std::vector<SubscriberPorts*> ports_;
  Doorbell& bell_;
  PollHandle* const handle_;
  const std::atomic<bool>* const interrupted_;
  const std::chrono::nanoseconds spin_;
  mutable std::atomic<bool> is_watched_{false};  ///< a program has asked for the file descriptor
  // The waits of two programs that answer each other include the waking of two threads on two hosts, if both
  // threads sleep meanwhile. If such programs spin, these times are saved. So that they begin to spin, a wait
  // of up to ten times the limit counts as short.
  SpinChoice spinning_{10};
};

}  // namespace sft::core
