// The thread that runs callbacks of the program for events, for the readers of a publisher and for lines of
// the log, one after the other, in the order in which they were posted. The agent does not run callbacks
// itself: it would do nothing else meanwhile, and would deadlock with a callback that waits for the agent.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>

#include "core/platform/agent.h"
#include "core/platform/thread.h"
#include "core/sync/mutex.h"
#include "sft/result.h"

namespace sft::core {

class CallbackThread {
 public:
  explicit CallbackThread(ThreadSpec spec) : spec_(std::move(spec)) {}

  /// Starts the thread. To be called before the first post(); does nothing if it was called before. Any
  /// thread.
  Result<void> start();
  /// Posts a call, and returns at once. If too many calls wait, because a callback does not return, this call
  /// is dropped. Any thread.
  void post(Agent::Task call);
  /// Calls what was posted before, then ends the thread.
  void stop() { agent_.stop(); }
  bool is_current_thread() const { return agent_.is_current_thread(); }
  /// Returns how many calls were dropped since the last call of this function. Returns 0 while there is no
  /// room for calls.
  std::uint64_t take_left_out();

 private:
  static constexpr std::size_t waiting_max = 10'000;

  const ThreadSpec spec_;
  std::atomic<std::size_t> waiting_{0};
  std::atomic<std::uint64_t> left_out_{0};
  Mutex mutex_;
  bool is_started_ SFT_GUARDED_BY(mutex_) = false;
  Agent agent_;
};

}  // namespace sft::core
