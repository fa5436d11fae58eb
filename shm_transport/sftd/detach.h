// Becoming a daemon, with the shell's patience: whoever started sftd sees it return when it is ready, or
// hears why it is not.
#pragma once

#include <string>

#include "shm_transport/file_lock.h"

namespace sft::shm {

/// Exit codes of sftd.
enum class ExitCode : unsigned char {
  running = 0,         ///< ready, or another one already was
  no_space = 1,        ///< too little in /dev/shm
  foreign_daemon = 2,  ///< another iceoryx daemon runs
  failed = 3,          ///< anything else, told in the message
};

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
