// Callbacks that any thread may call, and that can be taken away: after clear() no call is inside any more,
// so that whatever the callback uses may be destroyed. No lock is held while the callback runs.
//
// Only the callback and what it uses may go after clear(). The objects below outlive the functions that are
// called on them.
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <utility>

namespace sft::core {

/// Lets calls in until it is closed. Any number of threads may be inside at once, and each of them more than
/// once. Any thread.
class CallGate {
 public:
  /// Calls `function` unless the gate is closed; returns whether it did.
  template <class Function>
  bool call(Function&& function) {
    if (is_closed()) return false;  // a gate that is closing is not kept busy by those who come too late
    const Call call(*this);
    if (call.is_refused()) return false;
    std::forward<Function>(function)();
    return true;
  }

  bool is_closed() const noexcept { return (state_.load() & closed) != 0; }

  /// When it returns, no call is inside any more. A call that closes the gate itself waits for all others,
  /// but neither for itself nor for those that are closing the gate, too: these would wait for it.
  void close() noexcept {
    const std::uint32_t own = Call::of_this_thread(*this);
    std::uint32_t state = state_.fetch_or(closed) | closed;
    if (own > 0) {
      state = state_.fetch_add(own * one_closing) + own * one_closing;
      state_.notify_all();
    }
    while (inside(state) > (own > 0 ? closing(state) : 0)) {
      state_.wait(state);
      state = state_.load();
    }
    if (own > 0) state_.fetch_sub(own * one_closing);
  }

 private:
  /// One call, from the beginning to the end of the scope. The calls of a thread are linked, the innermost
  /// first, so that the thread knows where it is inside.
  class Call {
   public:
    explicit Call(CallGate& gate) noexcept
        : gate_(gate), outer_(innermost_), is_refused_((gate.state_.fetch_add(1) & closed) != 0) {
      innermost_ = this;
    }
    ~Call() {
      innermost_ = outer_;
      if ((gate_.state_.fetch_sub(1) & closed) != 0) gate_.state_.notify_all();
    }
    Call(const Call&) = delete;
    Call& operator=(const Call&) = delete;

    bool is_refused() const noexcept { return is_refused_; }

    static std::uint32_t of_this_thread(const CallGate& gate) noexcept {
      std::uint32_t calls = 0;
      for (const Call* call = innermost_; call != nullptr; call = call->outer_) {
        if (&call->gate_ == &gate) ++calls;
      }
      return calls;
    }

   private:
    static inline constinit thread_local const Call* innermost_ = nullptr;

    CallGate& gate_;
    const Call* const outer_;
    const bool is_refused_;
  };

  // The parts of the state: 1 for each call inside, one_closing for each of these that is within close(), and
  // one bit for the gate itself. It is one word, so that a call either sees that the gate is closed or is
  // seen by close().
  static constexpr std::uint32_t one_closing = std::uint32_t{1} << 16;
  static constexpr std::uint32_t closed = std::uint32_t{1} << 31;
  static constexpr std::uint32_t inside(std::uint32_t state) { return state % one_closing; }
  static constexpr std::uint32_t closing(std::uint32_t state) { return (state & ~closed) / one_closing; }

  std::atomic<std::uint32_t> state_{0};
};

/// A function together with its gate. The function may be empty.
template <class... Args>
class GuardedCall {
 public:
  using Function = std::function<void(Args...)>;
  explicit GuardedCall(Function function) : function_(std::move(function)) {}

  /// True if a call would do anything now.
  bool is_set() const noexcept { return function_ != nullptr && !gate_.is_closed(); }
  /// Does nothing if the function is empty or was taken away.
  void operator()(Args... args) {
    if (function_ != nullptr) gate_.call([&] { function_(std::forward<Args>(args)...); });
  }
  /// Takes the function away. When it returns, no call is inside any more, but for one that clears itself:
  /// see CallGate::close().
  void clear() noexcept { gate_.close(); }

 private:
  const Function function_;
  CallGate gate_;
};

}  // namespace sft::core
