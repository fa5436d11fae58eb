// Callbacks that any thread may call, and that can be cleared. After clear() no call is running any more,
// so that all objects that the callback uses may be destroyed. No lock is held while the callback runs.
//
// An object of these classes must outlive all calls of its functions, even after clear().
#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <utility>

#include "core/sync/mutex.h"

namespace sft::core {

/// Allows calls until it is closed. Any number of threads may be inside the gate at once, each of them more
/// than once. Any thread may use it.
class CallGate {
 public:
  /// Calls `function` unless the gate is closed. Returns true if the function was called.
  template <class Function>
  bool call(Function&& function) {
    if (is_closed()) return false;  // prevents new calls from keeping a closing gate busy
    const Call call(*this);
    if (call.is_refused()) return false;
    std::forward<Function>(function)();
    return true;
  }

  bool is_closed() const noexcept { return (state_.load() & closed) != 0; }

  /// Closes the gate. When close() returns, no call is inside the gate any more, with two exceptions: calls
  /// of this thread, and calls whose threads wait in close() for this thread. close() does not wait for
  /// these calls, because callbacks that close each other's gates would wait forever.
  void close() noexcept {
    const std::uint32_t own = Call::of(*this, Call::innermost());
    if (inside(state_.fetch_or(closed)) > own) wait_for_others();
  }

 private:
  /// One call, from the beginning to the end of the scope. The calls of a thread are linked, the innermost
  /// call first, so that a thread knows which gates it is inside.
  class Call {
   public:
    explicit Call(CallGate& gate) noexcept
        : gate_(gate), outer_(innermost_), is_refused_((gate.state_.fetch_add(1) & closed) != 0) {
      innermost_ = this;
    }
    ~Call() {
      innermost_ = outer_;
      if ((gate_.state_.fetch_sub(1) & closed) != 0) Closing::notify_change();
    }
    Call(const Call&) = delete;
    Call& operator=(const Call&) = delete;

    bool is_refused() const noexcept { return is_refused_; }

    static const Call* innermost() noexcept { return innermost_; }
    /// Returns the number of calls of one thread that are inside the gate. `innermost` is the innermost call
    /// of that thread.
    static std::uint32_t of(const CallGate& gate, const Call* innermost) noexcept {
      std::uint32_t calls = 0;
      for (const Call* call = innermost; call != nullptr; call = call->outer_) {
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

  /// A thread that waits in close(). All such threads of the process are in one list, which one mutex
  /// protects. A close() that need not wait does not lock this mutex.
  struct Closing {
    const CallGate* gate;
    const Call* innermost;
    Closing* next = nullptr;
    /// This thread waits, directly or indirectly, for the thread that is examining the list.
    bool depends = false;

    // Both are made at the first use, since global objects of programs may be constructed before all others
    // of SFT. They are never destroyed, since a callback may still wait when the program ends.
    static Mutex& mutex() {
      static Mutex& made = *new Mutex;
      return made;
    }
    static Condition& changed() {
      static Condition& made = *new Condition;
      return made;
    }
    static inline constinit Closing* first SFT_GUARDED_BY(mutex()) = nullptr;

    static void notify_change() noexcept {
      const Lock lock(mutex());
      changed().notify_all();
    }
    /// Returns the number of calls inside the gate being closed whose threads wait for this thread.
    std::uint32_t calls_of_dependents() SFT_REQUIRES(mutex()) {
      for (Closing* other = first; other != nullptr; other = other->next) other->depends = other == this;
      std::uint32_t calls = 0;
      for (bool found = true; found;) {
        found = false;
        for (Closing* other = first; other != nullptr; other = other->next) {
          if (other->depends || !other->waits_for_a_dependent()) continue;
          found = other->depends = true;
          calls += Call::of(*gate, other->innermost);
        }
      }
      return calls;
    }
    bool waits_for_a_dependent() const SFT_REQUIRES(mutex()) {
      for (const Closing* other = first; other != nullptr; other = other->next) {
        if (other->depends && Call::of(*gate, other->innermost) > 0) return true;
      }
      return false;
    }
  };

  void wait_for_others() noexcept {
    Closing own{.gate = this, .innermost = Call::innermost()};
    const std::uint32_t own_calls = Call::of(*this, own.innermost);
    Lock lock(Closing::mutex());
    own.next = std::exchange(Closing::first, &own);
    Closing::changed().notify_all();
    while (inside(state_.load()) > own_calls + own.calls_of_dependents()) Closing::changed().wait(lock);
    Closing** place = &Closing::first;
    while (*place != &own) place = &(*place)->next;
    *place = own.next;
    Closing::changed().notify_all();
  }

  // The state counts the calls inside, and has one bit that says that the gate is closed. The state is one
  // atomic word. So either a call sees that the gate is closed, or close() sees the call.
  static constexpr std::uint32_t closed = std::uint32_t{1} << 31;
  static constexpr std::uint32_t inside(std::uint32_t state) { return state & ~closed; }

  std::atomic<std::uint32_t> state_{0};
};

/// A function together with its gate. The function may be empty.
template <class... Args>
class GuardedCall {
 public:
  using Function = std::function<void(Args...)>;
  explicit GuardedCall(Function function) : function_(std::move(function)) {}

  /// Returns true if a call would have any effect now.
  bool is_set() const noexcept { return function_ != nullptr && !gate_.is_closed(); }
  /// Calls the function. Does nothing if the function is empty or was cleared.
  void operator()(Args... args) {
    if (function_ != nullptr) gate_.call([&] { function_(std::forward<Args>(args)...); });
  }
  /// Clears the function. When clear() returns, no call is running any more, except a call that has itself
  /// called clear() (CallGate::close()).
  void clear() noexcept { gate_.close(); }

 private:
  const Function function_;
  CallGate gate_;
};

}  // namespace sft::core
