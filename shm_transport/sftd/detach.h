// Turns the process that a shell has started into a daemon. The command returns to the shell when the
// daemon is ready or has failed. If the daemon has failed, the command prints the reason.
#pragma once

#include <string>

#include "shm_transport/host/file_lock.h"
#include "shm_transport/sftd/exit_code.h"

namespace sft::shm {

/// The process that the shell has started. It waits in the foreground for the result of the start.
class Starter {
 public:
  /// Returns a starter for a daemon that stays in the foreground: no process waits, and messages go to the
  /// standard streams.
  static Starter in_foreground() { return Starter(Descriptor()); }
  /// Returns in a new process without a terminal, whose standard streams are /dev/null. The old process exits
  /// when the result is reported, with the reported code.
  static Starter detach();

  /// Reports the result of the start. Only the first call counts.
  void report(ExitCode code, const std::string& message);

 private:
  explicit Starter(Descriptor channel) : channel_(std::move(channel)) {}
  Descriptor channel_;
};

}  // namespace sft::shm
