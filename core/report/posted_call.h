// A callback of the program that is called on the thread for callbacks, and can be taken away: after clear()
// it is not called any more, though calls of it may still wait there.
#pragma once

#include <functional>
#include <memory>
#include <utility>

#include "core/report/callback_thread.h"
#include "core/sync/guarded_call.h"

namespace sft::core {

/// The function may be empty.
template <class Argument>
class PostedCall {
 public:
  using Function = std::function<void(const Argument&)>;
  /// `thread` outlives this object; null: the function is called at once, on the thread that asks for it.
  PostedCall(Function function, CallbackThread* thread)
      : call_(function ? std::make_shared<GuardedCall<const Argument&>>(std::move(function)) : nullptr),
        thread_(thread) {}

  /// True if a call would do anything now.
  bool is_set() const noexcept { return call_ != nullptr && call_->is_set(); }
  void operator()(Argument argument) {
    if (!is_set()) return;
    if (thread_ == nullptr) return (*call_)(argument);
    thread_->post(call_.get(), [call = call_, argument = std::move(argument)] { (*call)(argument); });
  }
  /// When it returns, no call is inside any more, but for one that clears itself: see CallGate::close().
  void clear() noexcept {
    if (call_ != nullptr) call_->clear();
  }

 private:
  const std::shared_ptr<GuardedCall<const Argument&>> call_;
  CallbackThread* const thread_;
};

}  // namespace sft::core
