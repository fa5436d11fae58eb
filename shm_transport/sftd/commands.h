// The commands `sftd status` and `sftd stop`.
#pragma once

#include <chrono>

#include "shm_transport/sftd/exit_code.h"

namespace sft::shm {

/// Prints the last status of the daemon. If the daemon does not answer, the command also prints that.
ExitCode print_status(bool as_json);

/// Requests that the daemon ends, waits until it has ended, and names the programs that still used it.
ExitCode stop_daemon(std::chrono::milliseconds timeout);

}  // namespace sft::shm
