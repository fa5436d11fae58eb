// Attempts to open ports and to connect them: what has failed is tried again after a pause, and each reason
// is written to the log once. Used by the agent's thread.
#pragma once

#include <functional>

#include "core/platform/clock.h"
#include "core/platform/retry.h"
#include "core/report/node_log.h"
#include "sft/result.h"

namespace sft::core {

class PortAttempts {
 public:
  using Open = std::function<Result<void>()>;

  /// The log outlives this object.
  explicit PortAttempts(NodeLog& log) : log_(log) {}

  /// Returns true if open() was called and has succeeded. Does not call it while `retry` pauses.
  bool over_network(Retry& retry, const Open& open);
  /// The same where the daemon of shared memory is asked. A daemon that did not answer is not asked again for
  /// a while, on behalf of any endpoint: each such request takes until its deadline, and the agent does
  /// nothing else meanwhile.
  bool in_memory(Retry& retry, const Open& open);

  /// True if something failed that was tried by in_memory(), and may be tried again.
  bool may_retry_in_memory(const Retry& retry, Time now) const {
    return retry.due_again(now) && asking_daemon_.due(now);
  }
  /// Another daemon runs, which may be asked at once.
  void forget_daemon() { asking_daemon_ = {}; }

 private:
  static bool is_new_failure(Retry& retry, const Result<void>& outcome);

  NodeLog& log_;
  Retry asking_daemon_;
};

}  // namespace sft::core
