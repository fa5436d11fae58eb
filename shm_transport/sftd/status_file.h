// /dev/shm/sft_status: what the daemon last said of itself, in JSON. Everybody may read it, and so it can be
// read when the daemon does not answer: then one sees who had what when it stopped.
#pragma once

#include <optional>
#include <string>

#include "sft/result.h"
#include "shm_transport/sftd/status.h"

namespace sft::shm {

/// Replaces the file as a whole: who reads it meanwhile has the one or the other.
Result<void> write_status_file(const Status& status);
/// Empty where there is none of a daemon of that user.
std::optional<Status> read_status_file(uid_t daemon_user);
void remove_status_file() noexcept;

}  // namespace sft::shm
