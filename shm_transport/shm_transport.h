// The transport for samples within a host. Samples are stored in shared memory, which is built on iceoryx
// and which the daemon sftd hosts.
#pragma once

#include <memory>

#include "core/seam/transport.h"
#include "sft/result.h"
#include "shm_transport/host/shm_options.h"

namespace sft::shm {

/// Opens the transport without waiting, even if there is no daemon: Transport::poll() finds or starts the
/// daemon later.
/// The error Errc::invalid_argument names an account in daemon_users that does not exist.
Result<std::unique_ptr<core::SharedMemory>> open_shm_transport(const ShmOptions& options);

}  // namespace sft::shm
