// Calls of one thread, one after another, and another thread that waits for the one that is under way, but
// not for those that begin meanwhile: beside a thread that calls all the time it waits no longer.
//
// What it is for: the waiting thread has replaced something that each call reads once (a Snapshot), and wants
// to know when no call uses what was there before. The caller counts and then reads; the waiting thread
// replaces and then looks at the count. All four are sequentially consistent, so that at least one of them
// sees what the other did: a call that was not seen under way reads what is new.
#pragma once

#include <atomic>
#include <cstdint>

#include "core/sync/backoff.h"

namespace sft::core {

class CallCount {
 public:
  /// One call, from here to the end of the scope. The calling thread.
  class Call {
   public:
    explicit Call(CallCount& count) : count_(count) { count_.step(std::memory_order_seq_cst); }
    ~Call() { count_.step(std::memory_order_release); }
    Call(const Call&) = delete;
    Call& operator=(const Call&) = delete;

   private:
    CallCount& count_;
  };

  /// Until the call that is under way, if any, has ended.
  void wait_for_present_call() const {
    const std::uint64_t seen = steps_.load(std::memory_order_seq_cst);
    if (seen % 2 == 0) return;
    wait_until([&] { return steps_.load(std::memory_order_acquire) != seen; });
  }

 private:
  void step(std::memory_order order) { steps_.store(steps_.load(std::memory_order_relaxed) + 1, order); }

  std::atomic<std::uint64_t> steps_{0};  ///< odd within a call
};

}  // namespace sft::core
