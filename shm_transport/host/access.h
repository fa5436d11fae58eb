// Rights of a single user or group on a file, beyond those of its owner and group: an entry in its access
// control list. So processes of several users can share memory without all of them being in one group.
#pragma once

#include <sys/types.h>

#include <string>

#include "sft/result.h"

namespace sft::shm {

/// To read and write, whatever the file's own bits say. The caller owns the file, and no link at that path is
/// followed. Errc::unavailable where the file system has no such lists.
Result<void> grant_to_user(const std::string& path, uid_t user);
Result<void> grant_to_group(const std::string& path, gid_t group);

}  // namespace sft::shm
