// One subscriber without its message type. The class is the facade of three parts: the samples of the
// selections (feed.h), the waiting for samples (waiter.h), and the callback (callback_dispatch.h).
//
// Selections have numbers; 0 is the first, which every subscriber has.
//
// Any thread may call take(), take_latest() and wait(). Threads of transports call arrived(). These threads
// and the dispatcher call dispatch(). Only the agent calls functions that are marked so.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/negotiation/negotiation.h"
#include "core/platform/doorbell.h"
#include "core/platform/poll_handle.h"
#include "core/report/posted_call.h"
#include "core/seam/transport.h"
#include "core/subscribe/callback_dispatch.h"
#include "core/subscribe/feed.h"
#include "core/subscribe/recorder.h"
#include "core/subscribe/remote_copy.h"
#include "core/subscribe/subscriber_ports.h"
#include "core/subscribe/waiter.h"
#include "sft/detail/untyped.h"

namespace sft::core {

class SubscriberCore final : public ArrivalListener {
 public:
  struct Spec {
    std::string topic;
    const TypeSupport* type = nullptr;
    std::vector<Feed::Spec> feeds;  ///< one for each selection; only one if fields are recorded
    SubscriberOptions options;
    bool limits_samples = false;         ///< see detail::untyped::Requirement
    detail::untyped::Callback callback;  ///< empty: the program takes the samples
    /// The thread that calls options.on_event; null: the thread that causes the event.
    CallbackThread* event_callbacks = nullptr;
    std::shared_ptr<const void> type_owner{};  ///< keeps the type alive; null if it is static
    /// The memory for copies that have only the requested fields and parts. Copies are made of samples with
    /// parts of fields, and of all samples from shared memory if the options say `as_remote`. Null: no copies
    /// are made.
    std::shared_ptr<BufferPool> copies{};
    std::unique_ptr<PollHandle> poll_handle{};  ///< null: the subscriber has no file descriptor
    /// The time for which a sample in shared memory waits for an earlier one that was sent by UDP. It is far
    /// longer than UDP takes within a host, but not too long if the earlier sample is lost.
    std::chrono::nanoseconds diverted_timeout = std::chrono::milliseconds(100);
    std::uint32_t memory_depth = 0;  ///< the part of options.depth that shared memory keeps; 0: all
    /// The flag of Node::interrupt(), which must outlive the subscriber; null: there are no interrupts.
    const std::atomic<bool>* interrupted = nullptr;
    ReadTime callback_clock = &std::chrono::steady_clock::now;  ///< the clock that measures callbacks
  };

  /// `bell` is rung when samples arrive. `recorder` is null unless the requirement is recorded.
  SubscriberCore(Spec spec, Doorbell& bell, std::shared_ptr<Recorder> recorder);

  detail::untyped::Sample take();
  detail::untyped::Sample take_latest();
  bool wait(std::chrono::nanoseconds timeout) { return waiter_.wait_until(deadline_after(timeout)); }
  bool available() { return waiter_.available(); }
  /// Returns the file descriptor, or -1 if the subscriber has none.
  int file_descriptor() const { return waiter_.descriptor(); }

  // For subscribers with a callback or a file descriptor. These functions are called by the thread that
  // sleeps on the doorbell of such subscribers.

  /// Returns true if a sample waits that no thread is dispatching, or that the file descriptor does not show.
  bool waits_for_dispatch();
  /// Calls back for samples until the turn is over, or makes the file descriptor readable. If a call is
  /// running on another thread, the function returns at once, and that thread handles the samples.
  void dispatch();

  /// Calls back at once, which is quickest. If callbacks have taken long recently, the dispatcher calls back
  /// instead, so that the transport can continue.
  void arrived() noexcept override;

  /// Returns true while a callback may be running. If the result is false after close(), no callback will run
  /// any more.
  bool is_called_back() const { return callbacks_.is_called_back(); }
  /// See CallbackDispatch.
  std::uint64_t turns() const { return callbacks_.turns(); }
  bool holds_up_receiver() const { return callbacks_.holds_up_transport(); }
  /// Ends the callbacks. When it returns, no callback is running any more, except for a callback that itself
  /// called close().
  void close();

  /// Returns true if this thread is within a callback of any subscriber.
  static bool in_callback() noexcept { return CallbackDispatch::in_callback(); }

  const TypeSupport& type() const { return *spec_.type; }
  const Spec& spec() const { return spec_; }
  bool is_recorded() const { return recorder_ != nullptr; }
  bool has_callback() const { return static_cast<bool>(spec_.callback); }
  PostedCall<Event>& events() { return events_; }
  std::size_t selections() const { return feeds_.size(); }
  Feed& feed(std::size_t selection = 0) { return feeds_[selection]; }
  /// Returns the feed of a selection, or an error if there is no such selection.
  Result<Feed*> find(std::size_t selection);
  SubscriberPorts& ports(std::size_t selection = 0) { return feed(selection).ports(); }

  /// Wakes threads that wait for samples, since there may be samples for which no thread was woken. Any
  /// thread.
  void wake() { waiter_.wake(); }

 private:
  using Next = SubscriberPorts::Next;

  std::optional<std::size_t> first_in_turn();
  detail::untyped::Sample take(Next (SubscriberPorts::*choose)());
  /// A sample that is about to be delivered.
  struct Delivery : Next {
    PartReader* parts = nullptr;  ///< reads the parts of fields in place; null: all fields are in the sample
  };
  bool reduce(Delivery& delivery);
  detail::untyped::Sample wrap(Delivery delivery);
  void call_back(CallbackDispatch::Caller caller);

  const Spec spec_;
  Doorbell& bell_;
  const std::shared_ptr<Recorder> recorder_;
  const std::shared_ptr<RemoteCopy> remote_;  ///< null: no sample is reduced
  PostedCall<Event> events_;
  std::deque<Feed> feeds_;  ///< one feed for each selection, in the order of their numbers
  /// For each selection, how often its sample was passed over (see passed_over_max).
  std::vector<std::atomic<std::uint32_t>> passed_over_;
  Waiter waiter_;
  CallbackDispatch callbacks_;
};

}  // namespace sft::core
