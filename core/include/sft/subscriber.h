// Receiving messages of type T with requirement R: a declared mask, sft::recorded or sft::selected (mask.h).
#pragma once

#include <chrono>
#include <concepts>
#include <cstddef>
#include <string_view>
#include <utility>

#include "sft/detail/declared_selection.h"
#include "sft/detail/untyped.h"
#include "sft/sample.h"

namespace sft {

namespace detail {

/// A callback for samples of type S takes a `const S&`, or an `S` that it may keep.
template <class F, class S>
concept SampleCallback = std::invocable<F&, const S&> || std::invocable<F&, S>;

}  // namespace detail

/// Receives the samples of one topic; Node::subscriber() opens it. It can be moved, but not copied, and
/// keeps its node alive. Any thread may call any of its functions at any time. If several threads take
/// samples at once, each sample is taken by only one of them.
///
/// The program takes samples with take(), unless the subscriber has a callback. Threads of the node call
/// the callback for each sample, and never two threads at once. While the callback runs, further samples
/// stay in the queue, up to SubscriberOptions::depth of each selection. After the destructor no callback
/// runs any more (unless the destructor is called from within the callback). A callback must not throw: the
/// exception would end the program.
///
/// Callbacks for samples that came by UDP run on the receiving thread as long as they are short, since this
/// has the least latency. After a callback that took 0.2 ms or more, the callbacks of that subscriber run
/// on the node's thread for callbacks of shared memory, until 100 callbacks in a row were short. So a long
/// callback delays other callbacks of its node, but delays reception only once.
template <class T, Req<T> R = Req<T>(all<T>)>
class [[nodiscard]] Subscriber {
 public:
  /// For SFT's own code: Node::subscriber() opens subscribers.
  explicit Subscriber(detail::untyped::Subscriber subscriber) : subscriber_(std::move(subscriber)) {}

  /// Returns the oldest sample that was not taken yet, or an empty sample if there is none.
  [[nodiscard]] Sample<T, R> take() { return Sample<T, R>(subscriber_.take()); }
  /// Returns the newest sample of all publishers, by their stamps, or an empty sample if there is none. All
  /// other samples in the queue are skipped, and do not count as lost. SampleInfo::lost_before refers to
  /// the publisher of the returned sample; losses of another publisher are reported with the next sample of
  /// that publisher that is taken. With several selections, the function returns the newest sample of the
  /// selection whose samples have waited longest. So repeated calls return the newest sample of each
  /// selection, and then an empty one.
  [[nodiscard]] Sample<T, R> take_latest() { return Sample<T, R>(subscriber_.take_latest()); }
  /// Returns true as soon as there is a sample to take, or false when the timeout has passed or
  /// Node::interrupt() was called. The function spins for SubscriberOptions::spin, and then sleeps. If the
  /// program calls wait() for all subscribers of the node, and none of them has a publisher in shared
  /// memory, the calling thread itself receives datagrams for the node during the wait, so that no other
  /// thread has to wake it. In a callback for samples the function returns at once, since the callback may
  /// run on the receiving thread.
  bool wait(std::chrono::nanoseconds timeout) { return subscriber_.wait(timeout); }
  /// Returns a file descriptor for an event loop (epoll, poll, asio), in any trigger mode, or -1 without
  /// SubscriberOptions::pollable. It is readable while there is a sample to take. It can also be readable
  /// without a sample, if another thread has taken the sample or the sample has expired; then take()
  /// returns an empty sample and the descriptor is no longer readable. The program must wait on the
  /// descriptor, and must not read from it. The subscriber owns the descriptor and closes it.
  int file_descriptor() const { return subscriber_.file_descriptor(); }

  /// Returns the number of selections of the subscriber: 1 plus the number of
  /// SubscriberOptions::further_selections.
  std::size_t selections() const { return subscriber_.selections(); }

  /// Changes the maximum rate of selection `which`; publishers apply it shortly after. Returns an error if
  /// the rate is neither 0 nor from SubscriberOptions::slowest_rate_hz to fastest_rate_hz, or if there is no
  /// selection `which`.
  [[nodiscard]] Result<void> set_max_rate_hz(double max_rate_hz, std::size_t which = 0) {
    return subscriber_.set_max_rate_hz(max_rate_hz, which);
  }

  /// Changes selection `which`. Publishers apply the change shortly after, and their next sample then
  /// counts as changed (Selection::Gate). If the text has no maximum rate, the present rate remains.
  /// Returns an error, and changes nothing, if the subscriber records, if the text is wrong, or if there is
  /// no selection `which`.
  [[nodiscard]] Result<void> set_selection(std::string_view text, std::size_t which = 0) {
    return detail::declared_selection<R>()
        .and_then([&](const Selection& all) {
          return detail::selection_of_text(type(), all, detail::fields_of_text<R>, text);
        })
        .and_then([&](const Selection& selection) { return subscriber_.set_selection(selection, which); });
  }

  /// Returns the counts of selection `which`, and the state of each publisher of the topic. The status is
  /// empty if there is no selection `which`.
  SubscriberStatus status(std::size_t which = 0) const { return subscriber_.status(which); }
  /// Returns the fields that selection `which` requests and, if they are recorded, how often each field was
  /// read. The result is empty if there is no selection `which`.
  Requirements requirements(std::size_t which = 0) const { return subscriber_.requirements(which); }
  /// Returns the message type, which is valid as long as the subscriber.
  const TypeSupport& type() const { return subscriber_.type(); }

 private:
  detail::untyped::Subscriber subscriber_;
};

}  // namespace sft
