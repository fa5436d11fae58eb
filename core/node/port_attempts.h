// Attempts to open ports and to connect them. A failed attempt is repeated after a pause, and each reason is
// written to the log once. Used by the agent only.
#pragma once

#include <functional>

#include "core/platform/clock.h"
#include "core/platform/retry.h"
#include "core/report/node_log.h"
#include "core/seam/transport.h"
#include "sft/result.h"

namespace sft::core {

class PortAttempts {
 public:
  using Open = std::function<Result<void>()>;

  /// The arguments must outlive this object. `memory` may be null.
  explicit PortAttempts(NodeLog& log, const SharedMemory* memory = nullptr) : log_(log), memory_(memory) {}

  /// Calls open() unless `retry` forbids attempts at present. Returns true if open() was called and has
  /// succeeded.
  bool over_network(Retry& retry, const Open& open);
  /// Does the same as over_network() for ports that need the daemon of shared memory. If the daemon has not
  /// answered, it is not asked again for a while, for no endpoint, because the agent waits a moment for
  /// each answer. A pending answer is not a failure: open() is called again at the next look.
  bool in_memory(Retry& retry, const Open& open);

  /// Returns true if an attempt of in_memory() has failed and may be repeated now.
  bool may_retry_in_memory(const Retry& retry, Time now) const {
    return retry.due_again(now) && asking_daemon_.due(now);
  }
  /// Called when another daemon runs, since that daemon may be asked at once.
  void forget_daemon() { asking_daemon_ = {}; }

 private:
  static bool is_new_failure(Retry& retry, const Result<void>& outcome);

  NodeLog& log_;
  const SharedMemory* const memory_;
  Retry asking_daemon_;
};

}  // namespace sft::core
