// The groups whose members may use the memory. The kernel is asked who they are, whenever it can be: it also
// knows the groups that a service manager or a container gave to a process, which are in no file.
//
// sftd runs as the group of the writers, so that what it creates is theirs. Readers get, by access control
// lists, the right to read samples, and to read and write what manages them (a reader counts references
// there).
#pragma once

#include <sys/types.h>

#include <optional>
#include <string>

#include "sft/result.h"
#include "shm_transport/sftd/settings.h"

namespace sft::shm {

struct Groups {
  std::string writers{};  ///< also the name of the segment with the samples, in /dev/shm
  std::string readers{};  ///< empty if there are none apart from the writers
  std::optional<gid_t> reader_id{};
  /// Somebody in the group of writers. iceoryx looks groups up in files, by user; to it, all are this one.
  uid_t member = 0;
};

/// Changes the group of this process, if another one is to write. Call it before there are threads.
Result<Groups> take_up_groups(const AccessSettings& settings);

}  // namespace sft::shm
