// Watches whether the callback of one subscriber takes long, or waits long for those of other subscribers of
// the node. Used by the agent only.
#pragma once

#include <memory>
#include <optional>

#include "core/node/long_wait.h"
#include "core/platform/clock.h"
#include "core/subscribe/subscriber_core.h"

namespace sft::core {

class CallbackMonitor {
 public:
  explicit CallbackMonitor(std::shared_ptr<SubscriberCore> core) : core_(std::move(core)) {}

  struct LongWaits {
    std::optional<Time::duration> of_sample;    ///< a sample has waited for its callback
    std::optional<Time::duration> of_receiver;  ///< the thread that receives has waited for a callback
  };
  /// Returns each wait once, when it has become long. Long waits of samples are counted.
  LongWaits look(Time now);
  /// Returns true if a sample waits for the callback. That may take long.
  bool has_waiting_sample() const { return of_sample_.is_under_way(); }
  /// Returns true if this and several earlier looks in a row have found a callback running.
  bool is_in_long_callback();

 private:
  const std::shared_ptr<SubscriberCore> core_;
  LongWait of_sample_, of_receiver_;
  int looks_in_callback_ = 0;  ///< how many of the latest looks in a row found a callback running
};

}  // namespace sft::core
