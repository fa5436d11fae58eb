// A queue of calls of Python callbacks, for lines of the log and for events. Threads of SFT add calls, and
// a Python thread takes them. So no thread of SFT waits for the GIL. Any thread may call these functions.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace sft::python {

struct QueuedCall {
  std::uint64_t to = 0;  ///< the number of the callback
  std::string kind{};    ///< the kind of the event, or the level of the line of the log
  std::string node{};    ///< the name of the node at the other end of the event; empty for a line of the log
  std::string text{};
  std::uint64_t count = 1;
};

class CallbackQueue {
 public:
  /// Adds a call. Discards it if no thread takes calls.
  void put(QueuedCall call) {
    constexpr std::size_t most = 10'000;
    const std::lock_guard lock(mutex_);
    if (calls_.size() < most) calls_.push_back(std::move(call));
    arrived_.notify_one();
  }
  /// Waits until there are calls, and takes them. Must be called without the GIL.
  std::vector<QueuedCall> take(std::chrono::nanoseconds timeout) {
    std::unique_lock lock(mutex_);
    arrived_.wait_for(lock, timeout, [this] { return !calls_.empty(); });
    return std::exchange(calls_, {});
  }

 private:
  std::mutex mutex_;
  std::condition_variable arrived_;
  std::vector<QueuedCall> calls_;
};

}  // namespace sft::python
