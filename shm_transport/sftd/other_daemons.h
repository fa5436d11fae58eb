// Gives the reasons why this daemon must not start because of another daemon.
#pragma once

#include <optional>

#include "sft/result.h"
#include "shm_transport/sftd/start_failure.h"

namespace sft::shm {

/// Returns the reason not to start if another daemon lives. Returns nothing if no daemon lives in this
/// /tmp, as far as this account may find out.
std::optional<StartFailure> refuse_beside_the_living();

/// Returns an error that names the other daemon that has the lock in /tmp.
tl::unexpected<StartFailure> refuse_beside_another();

/// Returns an error that says why the host file in /dev/shm could not be locked.
tl::unexpected<StartFailure> refuse_host_file(const Error& error);

}  // namespace sft::shm
