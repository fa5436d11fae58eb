// `sftd status` and `sftd stop`.
#pragma once

#include <chrono>

#include "shm_transport/sftd/exit_code.h"

namespace sft::shm {

/// Prints what the daemon last told, also while it does not answer, and then says so.
ExitCode print_status(bool as_json);

/// Asks it to end, waits until it has, and says who still used it.
ExitCode stop_daemon(std::chrono::milliseconds patience);

}  // namespace sft::shm
