// A user's callback between the agent, which calls it with news, and the destructor of what it belongs to,
// after which it is called no more.
#pragma once

#include <atomic>
#include <functional>
#include <thread>
#include <utility>

#include "sft/event.h"

namespace sft::core {

template <class News>
class NewsSink {
 public:
  using Call = std::function<void(const News&)>;
  explicit NewsSink(Call call) : call_(std::move(call)) {}

  bool wanted() const { return static_cast<bool>(call_) && !closed_.load(); }

  /// The agent's thread.
  void tell(const News& news) {
    if (!wanted()) return;
    caller_.store(std::this_thread::get_id());
    calling_.store(true);
    if (wanted()) call_(news);
    calling_.store(false);
    calling_.notify_all();
  }

  /// Any thread. When it returns no call is under way, except for one in which it is called itself.
  void close() {
    closed_.store(true);
    if (calling_.load() && caller_.load() == std::this_thread::get_id()) return;
    calling_.wait(true);
  }

 private:
  const Call call_;
  // All sequentially consistent: either tell() sees that it is closed, or close() that a call is under way.
  std::atomic<bool> closed_{false};
  std::atomic<bool> calling_{false};
  std::atomic<std::thread::id> caller_{};
};

using EventSink = NewsSink<Event>;

}  // namespace sft::core
