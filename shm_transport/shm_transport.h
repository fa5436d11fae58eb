// Samples within a host: through shared memory, on iceoryx, hosted by the daemon sftd.
#pragma once

#include <memory>

#include "core/seam/transport.h"
#include "sft/result.h"
#include "shm_transport/host/shm_options.h"

namespace sft::shm {

/// Does not wait and does not fail for want of a daemon: Transport::poll looks after that.
/// Errc::invalid_argument names an account in daemon_users that does not exist.
Result<std::unique_ptr<core::Transport>> open_shm_transport(const ShmOptions& options);

}  // namespace sft::shm
