#include "core/platform/agent.h"

#include <algorithm>
#include <utility>

namespace sft::core {

Result<void> Agent::start(const ThreadSpec& thread, Duties duties) {
  duties_ = std::move(duties);
  return start_thread(thread, [this] { run(); }).map([this](std::thread&& t) { thread_ = std::move(t); });
}

void Agent::stop() {
  if (!thread_.joinable()) return;
  {
    const Lock lock(mutex_);
    stopping_ = true;
  }
  posted_.notify_one();
  thread_.join();
}

void Agent::post(Task task) {
  {
    const Lock lock(mutex_);
    tasks_.push_back(std::move(task));
  }
  posted_.notify_one();
}

bool Agent::is_behind(std::size_t endpoints) {
  const Lock lock(mutex_);
  return tasks_.size() >= std::max(behind_from, endpoints / 2);
}

void Agent::run() {
  thread_id_.store(std::this_thread::get_id());
  std::vector<Task> batch;
  auto next_tick = std::chrono::steady_clock::now();
  for (;;) {
    bool stopping = false;
    {
      Lock lock(mutex_);
      while (!stopping_ && tasks_.empty() && posted_.wait_until(lock, next_tick)) continue;
      batch.swap(tasks_);
      stopping = stopping_;
    }
    for (const Task& task : batch) task();
    if (stopping && batch.empty()) return;
    if (!batch.empty()) {
      const auto pause = duties_.idle();
      next_tick = std::min(next_tick, std::chrono::steady_clock::now() + pause);
    }
    batch.clear();
    if (const auto now = std::chrono::steady_clock::now(); now >= next_tick) {
      next_tick = now + duties_.tick();
    }
  }
}

}  // namespace sft::core
