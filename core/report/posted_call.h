// A callback of the program that runs on the callback thread and can be cleared. After clear() it is not
// called any more, even if calls of it are still queued for that thread.
#pragma once

#include <functional>
#include <memory>
#include <utility>

#include "core/report/callback_thread.h"
#include "core/sync/guarded_call.h"

namespace sft::core {

/// A callback with one argument. The function may be empty.
template <class Argument>
class PostedCall {
 public:
  using Function = std::function<void(const Argument&)>;
  /// `thread` must outlive this object. If it is null, the function is called at once, on the calling thread.
  PostedCall(Function function, CallbackThread* thread)
      : call_(function ? std::make_shared<GuardedCall<const Argument&>>(std::move(function)) : nullptr),
        thread_(thread) {}

  /// Returns true if a call would have any effect now.
  bool is_set() const noexcept { return call_ != nullptr && call_->is_set(); }
  void operator()(Argument argument) {
    if (!is_set()) return;
    if (thread_ == nullptr) return (*call_)(argument);
    thread_->post(call_.get(), [call = call_, argument = std::move(argument)] { (*call)(argument); });
  }
  /// Clears the function. When clear() returns, no call is running any more, except a call that has itself
  /// called clear() (CallGate::close()).
  void clear() noexcept {
    if (call_ != nullptr) call_->clear();
  }

 private:
  const std::shared_ptr<GuardedCall<const Argument&>> call_;
  CallbackThread* const thread_;
};

}  // namespace sft::core
