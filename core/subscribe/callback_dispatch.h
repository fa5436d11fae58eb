// Calls one subscriber's callback, never twice at once. The callback runs on the receiving thread while
// callbacks are quick, and on the dispatcher's thread while they take long. Both threads call back for other
// subscribers, too, so each subscriber has a turn and then has to wait for the next one. Any thread.
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <utility>

#include "core/platform/clock.h"
#include "core/sync/guarded_call.h"
#include "sft/detail/untyped.h"

namespace sft::core {

class CallbackDispatch {
 public:
  enum class Caller : std::uint8_t { dispatcher, transport };
  /// The length of a turn. It ends with the first callback that returns after this time. So a subscriber with
  /// longer callbacks has one callback per turn.
  static constexpr std::chrono::milliseconds turn{1};

  /// The callback must outlive this object.
  explicit CallbackDispatch(const detail::untyped::Callback& callback,
                            ReadTime now = &std::chrono::steady_clock::now)
      : callback_(callback), now_(now) {}

  /// Calls back for the samples in `samples`, which has take() and available(), until there is none or the
  /// turn is over. If a call is running on another thread, the function returns at once, and that thread
  /// handles the samples. Returns false if the dispatcher has to call back for the rest in its next round.
  template <class Samples>
  bool dispatch(Caller caller, Samples& samples) {
    bool done = true;
    gate_.call([&] { done = call_back_for_arrivals(caller, samples); });
    return done;
  }
  /// Returns true if no thread is calling back. Then samples that are present now wait for dispatch().
  bool is_idle() const { return pending_.load() == 0 && !gate_.is_closed(); }
  /// Returns true after a callback that took long, until many callbacks in a row were quick.
  bool is_slow() const { return is_slow_.load(); }

  /// Returns true while a callback may be running. If the result is false after close(), no callback will run
  /// any more.
  bool is_called_back() const { return pending_.load() != 0; }
  /// Ends the callbacks. When it returns, no callback is running any more, except for a callback that itself
  /// called close().
  void close() noexcept { gate_.close(); }

  /// Returns true if this thread is within a callback of any subscriber.
  static bool in_callback() noexcept;
  /// Returns a number that changes when callbacks run.
  std::uint64_t turns() const { return turns_.load(std::memory_order_relaxed); }
  /// Returns true while a callback may be running on a thread of the transport.
  bool holds_up_transport() const { return is_called_back() && is_on_transport_.load(); }

 private:
  template <class Samples>
  bool call_back_for_arrivals(Caller caller, Samples& samples);
  template <class Samples>
  bool call_back_in_turn(Caller caller, Samples& samples, Time& time, Time turn_ends);
  Time call_back(detail::untyped::Sample sample, Time before);

  const detail::untyped::Callback& callback_;
  const ReadTime now_;
  // The following members are sequentially consistent. So either is_idle() on one thread or the end of
  // dispatch() on another thread sees the action of the other thread.
  /// The number of arrivals that are not dispatched yet. The thread that raises it from 0 dispatches.
  std::atomic<std::uint32_t> pending_{0};
  CallGate gate_;
  std::atomic<bool> is_slow_{false};
  std::atomic<std::uint64_t> turns_{0};
  std::atomic<bool> is_on_transport_{false};  ///< true: the last turn was on a thread of the transport
  int quick_in_a_row_ = 0;                    ///< written only by the thread that dispatches
};

template <class Samples>
bool CallbackDispatch::call_back_for_arrivals(Caller caller, Samples& samples) {
  if (pending_.fetch_add(1) != 0) return true;  // the thread that dispatches sees the new count
  turns_.fetch_add(1, std::memory_order_relaxed);
  is_on_transport_.store(caller == Caller::transport);
  Time time = now_();
  const Time turn_ends = time + turn;
  for (std::uint32_t seen = 1;;) {
    if (!call_back_in_turn(caller, samples, time, turn_ends)) {
      pending_.store(0);
      return false;
    }
    const std::uint32_t before = pending_.fetch_sub(seen);
    if (before != seen) {
      seen = before - seen;
      continue;
    }
    // Another thread may have added a sample while the count was not yet zero. It left the sample to this
    // thread, which may not have seen it. So this thread checks again. The fence keeps the check after the
    // update of the count, even if the check takes no lock.
    std::atomic_thread_fence(std::memory_order_seq_cst);
    if (gate_.is_closed() || !samples.available() || pending_.fetch_add(1) != 0) return true;
    seen = 1;
  }
}

/// Calls back until the samples or the turn end. Returns false if samples may be left. Sets `time` to the
/// time at which the last callback returned.
template <class Samples>
bool CallbackDispatch::call_back_in_turn(Caller caller, Samples& samples, Time& time, Time turn_ends) {
  while (!gate_.is_closed()) {
    detail::untyped::Sample sample = samples.take();
    if (!sample) return true;
    time = call_back(std::move(sample), time);
    if (time >= turn_ends || (caller == Caller::transport && is_slow_.load())) return false;
  }
  return true;
}

}  // namespace sft::core
