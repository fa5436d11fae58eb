// The thread that calls a program back with events, with the readers of a publisher and with lines of the
// log, one after the other in the order in which they were posted. The agent does not call back itself: it
// would do nothing else meanwhile, and would wait for a callback that waits for the agent.
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

  /// Before the first post(); does nothing if it was called before. Any thread.
  Result<void> start();
  /// Any thread; returns at once. If too many wait, because a callback does not return, the call is left out.
  void post(Agent::Task call);
  /// Calls what was posted before, then ends the thread.
  void stop() { agent_.stop(); }
  bool is_current_thread() const { return agent_.is_current_thread(); }
  /// Returns how many calls were left out since it was called last, once there is room for calls again.
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
