// News for callbacks of Python: lines of the log and events. Threads of SFT put them in, and a thread of
// Python takes them out, so that no thread of SFT waits for the GIL. Any thread.
#pragma once

#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <mutex>
#include <string>
#include <utility>
#include <vector>

namespace sft::python {

struct Letter {
  std::uint64_t to = 0;  ///< the number of the callback
  std::string kind{};    ///< the kind of the event, or the level of the line of the log
  std::string node{};    ///< the name of the node at the other end of the event; empty for a line of the log
  std::string text{};
  std::uint64_t count = 1;
};

class Mailbox {
 public:
  /// Leaves the letter out if nobody takes them.
  void put(Letter letter) {
    constexpr std::size_t most = 10'000;
    const std::lock_guard lock(mutex_);
    if (letters_.size() < most) letters_.push_back(std::move(letter));
    arrived_.notify_one();
  }
  /// Waits until there are letters. Without the GIL.
  std::vector<Letter> take(std::chrono::nanoseconds timeout) {
    std::unique_lock lock(mutex_);
    arrived_.wait_for(lock, timeout, [this] { return !letters_.empty(); });
    return std::exchange(letters_, {});
  }

 private:
  std::mutex mutex_;
  std::condition_variable arrived_;
  std::vector<Letter> letters_;
};

}  // namespace sft::python
