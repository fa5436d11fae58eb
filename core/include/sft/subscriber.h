// Receiving messages of type T with requirement R: a declared mask, or sft::recorded.
#pragma once

#include <chrono>
#include <concepts>
#include <utility>

#include "sft/detail/untyped.h"
#include "sft/sample.h"

namespace sft {

namespace detail {

/// A callback for samples of type S takes a `const S&`, or an `S` that it may keep.
template <class F, class S>
concept SampleCallback = std::invocable<F&, const S&> || std::invocable<F&, S>;

}  // namespace detail

/// Moved, not copied. All of its functions may be called by any thread at any time, also at once: each sample
/// is taken by one of them. Without a callback samples are taken. With one: the callback is called for each
/// sample, never twice at once, from threads of the node; while it runs, further samples queue up to the
/// depth. After the destructor no callback runs any more (unless it is called from within the callback
/// itself).
///
/// Callbacks for what comes by UDP run on the thread that receives, which is quickest, as long as they are
/// quick. After one that took 0.2 ms or more that subscriber's run on a thread that all callbacks of the node
/// for samples in shared memory share, until 100 in a row were quick: a callback that takes long holds up
/// other callbacks of its node, but, except for the first time, no reception.
template <class T, Req<T> R = Req<T>(all<T>)>
class Subscriber {
 public:
  explicit Subscriber(detail::untyped::Subscriber subscriber) : subscriber_(std::move(subscriber)) {}

  /// The oldest sample not yet taken; empty if there is none.
  [[nodiscard]] Sample<T, R> take() { return Sample<T, R>(subscriber_.take()); }
  /// The newest sample of all publishers, by the clocks of these; of one publisher it is its last. All others
  /// that are there are passed over and not counted as lost. What was lost before it is told of its own
  /// publisher; of others, with the next sample of these that is taken.
  [[nodiscard]] Sample<T, R> take_latest() { return Sample<T, R>(subscriber_.take_latest()); }
  /// Until there is something to take or the time is over; tells which. Looks for SubscriberOptions::spin,
  /// then sleeps. Where the subscribers of its node are only waited for, and hear nobody on this host in
  /// shared memory, the thread does the node's receiving meanwhile: nobody has to wake it.
  bool wait(std::chrono::nanoseconds timeout) { return subscriber_.wait(timeout); }
  /// For an event loop (epoll, poll, asio), in any trigger mode: readable while there is something to take,
  /// no longer once the last sample was taken. Another thread that takes, or a sample that expires, can leave
  /// it readable without a sample: take() then finds none, and it ends. It belongs to the subscriber and
  /// lasts as long; it is to be waited on, not read. -1 without SubscriberOptions::pollable.
  int file_descriptor() const { return subscriber_.file_descriptor(); }

  /// Another SubscriberOptions::max_rate_hz from now on, on any thread; publishers follow in a moment. An
  /// error if it is no rate.
  Result<void> set_max_rate_hz(double max_rate_hz) { return subscriber_.set_max_rate_hz(max_rate_hz); }

  /// Counts, and each publisher of the topic. Any thread.
  SubscriberStatus status() const { return subscriber_.status(); }
  /// What it asks for and, where fields are recorded, how often each was read. Any thread.
  Requirements requirements() const { return subscriber_.requirements(); }
  /// The message type. Any thread; valid as long as the subscriber.
  const TypeSupport& type() const { return subscriber_.type(); }

 private:
  detail::untyped::Subscriber subscriber_;
};

}  // namespace sft
