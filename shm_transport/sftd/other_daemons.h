// Says why this daemon must not start beside another one.
#pragma once

#include <optional>

#include "sft/result.h"
#include "shm_transport/sftd/start_failure.h"

namespace sft::shm {

/// Returns nothing if no daemon lives in this /tmp, as far as this account may ask.
std::optional<StartFailure> refuse_beside_the_living();

/// Says which other daemon has the lock in /tmp.
tl::unexpected<StartFailure> refuse_beside_another();

/// Says why the host file in /dev/shm could not be locked.
tl::unexpected<StartFailure> refuse_host_file(const Error& error);

}  // namespace sft::shm
