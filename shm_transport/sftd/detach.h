// Becoming a daemon, with the shell's patience: whoever started sftd sees it return when it is ready, or
// hears why it is not.
#pragma once

#include <string>

#include "shm_transport/host/file_lock.h"
#include "shm_transport/sftd/exit_code.h"

namespace sft::shm {

/// The process that was started, waiting in the foreground for what becomes of the daemon.
class Starter {
 public:
  /// Nobody waits: messages go to the standard streams of this process.
  static Starter in_foreground() { return Starter(Descriptor()); }
  /// Returns in a new process without terminal, whose standard streams are /dev/null. The old one exits when
  /// the result is told, with its code.
  static Starter detach();

  /// Only once, and only the first time matters.
  void tell(ExitCode code, const std::string& message);

 private:
  explicit Starter(Descriptor channel) : channel_(std::move(channel)) {}
  Descriptor channel_;
};

}  // namespace sft::shm
