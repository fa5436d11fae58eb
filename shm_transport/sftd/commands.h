// The commands `sftd status` and `sftd stop`.
#pragma once

#include <chrono>

#include "shm_transport/sftd/exit_code.h"

namespace sft::shm {

/// Prints the last status of the daemon. If the daemon does not answer, the command prints that as well.
ExitCode print_status(bool as_json);

/// Asks the daemon to end, waits until it has ended, and names the programs that still used it.
ExitCode stop_daemon(std::chrono::milliseconds timeout);

}  // namespace sft::shm
