// Gives a single user or group rights to a file, by an entry in the access control list of the file. So
// processes of several users can share memory even if the users have no common group.
#pragma once

#include <sys/types.h>

#include <string>

#include "sft/result.h"

namespace sft::shm {

/// Gives `user` the right to read and write the file, whatever its mode bits say. The caller must own the
/// file. A link at the path is not followed. The error is Errc::unavailable if the file system has no
/// access control lists.
Result<void> grant_to_user(const std::string& path, uid_t user);
Result<void> grant_to_group(const std::string& path, gid_t group);

}  // namespace sft::shm
