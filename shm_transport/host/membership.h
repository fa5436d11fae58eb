// Tells a program that the daemon does not serve how to become a member of the daemon's group.
#pragma once

#include <sys/types.h>

#include <string>

namespace sft::shm {

/// Where a program stands with regard to a group: what the kernel has given to this process, and what the
/// files of groups say of its user.
struct Membership {
  std::string group{};  ///< empty: the group has no name here (a container may have other files)
  gid_t group_id = 0;
  std::string user{};      ///< empty: the user has no name here
  bool is_listed = false;  ///< the files name the user as a member, whether or not this process has the group

  static Membership of_this_process(gid_t group);
};

/// Says in one sentence what keeps the user out of the group that sftd serves, and which command changes it.
std::string how_to_join(const Membership& membership);

}  // namespace sft::shm
