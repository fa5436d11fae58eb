// The status file /dev/shm/sft_status, in which the daemon writes its status as JSON. Every account may
// read it. The file can also be read when the daemon does not answer. In that case it shows the usage at
// the moment at which the daemon stopped answering.
#pragma once

#include <optional>
#include <string>

#include "sft/result.h"
#include "shm_transport/sftd/status.h"

namespace sft::shm {

/// Replaces the whole file. A process that reads the file during the call gets either the old status or the
/// new status.
Result<void> write_status_file(const Status& status);
/// Returns nothing if there is no status file of a daemon of this user.
std::optional<Status> read_status_file(uid_t daemon_user);
void remove_status_file() noexcept;

}  // namespace sft::shm
