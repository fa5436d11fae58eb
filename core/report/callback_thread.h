// The thread that runs callbacks of the program for events, for the readers of a publisher and for lines of
// the log, one after the other. The calls of one source, such as the events of one subscriber, keep the
// order in which they were posted. Sources take turns. So a callback that is slower than its events delays
// another source by no more than one call. The agent does not run callbacks itself, because it could do no
// other work meanwhile, and would deadlock with a callback that waits for the agent.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <map>

#include "core/platform/agent.h"
#include "core/platform/thread.h"
#include "core/sync/mutex.h"
#include "sft/result.h"

namespace sft::core {

class CallbackThread {
 public:
  explicit CallbackThread(ThreadSpec spec) : spec_(std::move(spec)) {}

  /// Starts the thread. Must be called before the first post(). Does nothing if the thread was started
  /// before. Any thread may call this.
  Result<void> start();
  /// Posts a call, and returns at once. If `waiting_max` calls of the source are queued, for example
  /// because a callback does not return, the call is dropped. `source` is an address that identifies the
  /// source. No other source must use the address while calls of this source are queued. Any thread may
  /// call this.
  void post(const void* source, Agent::Task call);
  /// Runs the calls that were posted before, and then ends the thread.
  void stop() { agent_.stop(); }
  /// Returns true within a call of any CallbackThread of the process.
  static bool in_call() noexcept { return in_call_; }
  /// Returns the number of calls that were dropped since the last call of this function. Returns 0 while
  /// the queue of any source is full.
  std::uint64_t take_left_out();

 private:
  static constexpr std::size_t waiting_max = 10'000;  ///< the maximum number of queued calls of each source

  void call_next();

  static inline constinit thread_local bool in_call_ = false;
  const ThreadSpec spec_;
  Mutex start_mutex_;  ///< held while the thread is started
  bool is_started_ SFT_GUARDED_BY(start_mutex_) = false;
  Mutex mutex_;
  /// The queued calls of each source; no deque is empty.
  std::map<const void*, std::deque<Agent::Task>> waiting_ SFT_GUARDED_BY(mutex_);
  /// All sources with queued calls, in the order of their turns; the next source is first.
  std::deque<const void*> turns_ SFT_GUARDED_BY(mutex_);
  std::uint64_t left_out_ SFT_GUARDED_BY(mutex_) = 0;
  Agent agent_;
};

}  // namespace sft::core
