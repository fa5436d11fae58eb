// The groups whose members may use the shared memory. Where possible, the kernel decides which processes
// are members. The kernel also knows the groups that a service manager or a container has given to a
// process, and that are in no file.
//
// sftd runs as the group of the writers, so that the files that it creates belong to this group. Readers
// get rights by access control lists: they may read the samples, and may read and write the management
// segment, where a reader counts references.
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>

#include "sft/result.h"
#include "shm_transport/sftd/settings.h"

namespace sft::shm {

struct Groups {
  /// The group of the writers; the segment with the samples in /dev/shm has this name, too.
  std::string writers{};
  /// The group of the readers; empty if only the group of the writers may use the memory.
  std::string readers{};
  std::optional<gid_t> reader_id{};
  /// A user in the group of writers. iceoryx looks up the groups of a user in files, so sftd registers
  /// every process under this user.
  uid_t member = 0;
};

/// Changes the group of this process if the settings name another group of writers. Must be called before
/// there are threads.
Result<Groups> take_up_groups(const AccessSettings& settings);

}  // namespace sft::shm
