// Explains to the user of a program that the daemon does not serve how to become a member of the daemon's
// group.
#pragma once

#include <sys/types.h>

#include <string>

namespace sft::shm {

/// A group, the user of this process, and whether the host's group files list that user as a member.
struct Membership {
  /// Name of the group; empty: the group has no name here (a container may have other files).
  std::string group{};
  gid_t group_id = 0;
  std::string user{};  ///< name of the user; empty: the user has no name here
  /// True if the group files list the user, whether or not this process has the group.
  bool is_listed = false;

  static Membership of_this_process(gid_t group);
};

/// Returns a sentence that says what keeps the user out of the group that sftd serves, and which command
/// changes that.
std::string how_to_join(const Membership& membership);

}  // namespace sft::shm
