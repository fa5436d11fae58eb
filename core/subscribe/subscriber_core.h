// One subscriber without its message type: the facade of the samples of its selections (feed.h), of waiting
// for them (waiter.h) and of its callback (callback_dispatch.h).
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
    detail::untyped::Callback callback;  ///< empty: samples are taken
    CallbackThread* event_callbacks =
        nullptr;  ///< the thread that calls options.on_event; null: the causing one
    std::shared_ptr<const void> type_owner{};  ///< keeps the type alive; null if it is static
    /// The memory for copies that have only what was asked for: of samples with parts of fields, and of all
    /// samples from shared memory if the options say `as_remote`. Null: there are no such copies.
    std::shared_ptr<BufferPool> copies{};
    std::unique_ptr<PollHandle> poll_handle{};  ///< null: the subscriber has no file descriptor
    /// How long a sample in shared memory waits for an earlier one that was sent by UDP. This is far longer
    /// than UDP takes within a host, but not too long in case the earlier sample is lost.
    std::chrono::nanoseconds diverted_timeout = std::chrono::milliseconds(100);
    std::uint32_t memory_depth = 0;  ///< the part of options.depth that shared memory keeps; 0: all
    const std::atomic<bool>* interrupted = nullptr;  ///< outlives the subscriber; null: nothing interrupts it
    ReadTime callback_clock = &std::chrono::steady_clock::now;  ///< the clock that measures callbacks
  };

  /// `bell` is rung when samples arrive; `recorder` is null unless the requirement is recorded.
  SubscriberCore(Spec spec, Doorbell& bell, std::shared_ptr<Recorder> recorder);

  detail::untyped::Sample take();
  detail::untyped::Sample take_latest();
  bool wait(std::chrono::nanoseconds timeout) { return waiter_.wait_until(deadline_after(timeout)); }
  bool available() { return waiter_.available(); }
  /// Returns -1 if the subscriber has no file descriptor.
  int file_descriptor() const { return waiter_.descriptor(); }

  // For subscribers with a callback or a file descriptor. Called by the thread that sleeps on their doorbell.

  /// Returns true if a sample waits that no thread is dispatching, or that the file descriptor does not show.
  bool waits_for_dispatch();
  /// Calls back for samples until the turn is over, or makes the file descriptor readable. Returns at once if
  /// a call is under way on another thread, which then handles the samples.
  void dispatch();

  /// Calls back at once, which is quickest. If callbacks have taken long lately, the dispatcher calls back
  /// instead, so that the transport can go on.
  void arrived() noexcept override;

  /// Returns true while a callback may be running. If it returns false after close(), none will run any more.
  bool is_called_back() const { return callbacks_.is_called_back(); }
  /// See CallbackDispatch.
  std::uint64_t turns() const { return callbacks_.turns(); }
  bool holds_up_receiver() const { return callbacks_.holds_up_transport(); }
  /// After it returns no callback runs any more, except for one from which it was called.
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

  std::optional<std::size_t> oldest();
  detail::untyped::Sample take(Next (SubscriberPorts::*choose)());
  /// A sample that is about to be delivered.
  struct Delivery : Next {
    PartReader* parts = nullptr;  ///< reads the parts of fields in place; null: all is in the sample
  };
  bool reduce(Delivery& delivery);
  detail::untyped::Sample wrap(Delivery delivery);
  void call_back(CallbackDispatch::Caller caller);

  const Spec spec_;
  Doorbell& bell_;
  const std::shared_ptr<Recorder> recorder_;
  const std::shared_ptr<RemoteCopy> remote_;  ///< null: no sample is reduced
  PostedCall<Event> events_;
  std::deque<Feed> feeds_;  ///< one feed per selection; the index is the number of the selection
  Waiter waiter_;
  CallbackDispatch callbacks_;
};

}  // namespace sft::core
