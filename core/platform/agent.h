// The node's agent: one thread for all work that may take a while or must not be done by two threads at
// once. This is negotiation, opening and closing of ports, announcements, maintenance of transports. Other
// threads post tasks to it.
#pragma once

#include <atomic>
#include <chrono>
#include <cstddef>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "core/platform/thread.h"
#include "core/sync/mutex.h"
#include "sft/result.h"

namespace sft::core {

class Agent {
 public:
  using Task = std::function<void()>;

  /// The work of the thread in addition to tasks. `tick` is called when the time that `tick` or `idle`
  /// returned last has passed. `idle` is called after each batch of tasks, since the next tick may then be
  /// due earlier. Both return the time until the next tick.
  struct Duties {
    std::function<std::chrono::milliseconds()> tick;
    std::function<std::chrono::milliseconds()> idle;
  };

  Agent() = default;
  ~Agent() { stop(); }
  Agent(const Agent&) = delete;
  Agent& operator=(const Agent&) = delete;

  Result<void> start(const ThreadSpec& thread, Duties duties);

  /// Posts a task, and returns at once. Tasks run in the order in which they were posted. Any thread may
  /// call this, even before start().
  void post(Task task);
  /// Returns true if at least `behind_from` tasks are queued, and at least half as many as there are
  /// `endpoints`. Threads that post very many tasks should then wait for the agent. After each batch of
  /// tasks the agent looks at all endpoints, so that small batches would make very many endpoints slow.
  bool is_behind(std::size_t endpoints = 0);
  static constexpr std::size_t behind_from = 256;
  /// Runs the tasks that were posted before, and then ends the thread. Tasks that are posted later are not
  /// run.
  void stop();
  bool is_current_thread() const { return std::this_thread::get_id() == thread_id_.load(); }

 private:
  void run();

  Duties duties_;
  Mutex mutex_;
  Condition posted_;
  std::vector<Task> tasks_ SFT_GUARDED_BY(mutex_);
  bool stopping_ SFT_GUARDED_BY(mutex_) = false;
  std::atomic<std::thread::id> thread_id_{};
  std::thread thread_;
};

}  // namespace sft::core
