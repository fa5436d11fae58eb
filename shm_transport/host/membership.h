// Tells a program that the daemon does not serve how to become a member of the daemon's group.
#pragma once

#include <sys/types.h>

#include <string>

namespace sft::shm {

/// A group, the user of this process, and whether the host's files of groups list that user as a member.
struct Membership {
  std::string group{};  ///< empty: the group has no name here (a container may have other files)
  gid_t group_id = 0;
  std::string user{};      ///< empty: the user has no name here
  bool is_listed = false;  ///< the files list the user, whether or not this process has the group

  static Membership of_this_process(gid_t group);
};

/// Says in one sentence what keeps the user out of the group that sftd serves, and which command changes it.
std::string how_to_join(const Membership& membership);

}  // namespace sft::shm
