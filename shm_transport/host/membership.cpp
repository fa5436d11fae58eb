#include "shm_transport/host/membership.h"

#include <grp.h>
#include <pwd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <vector>

namespace sft::shm {

namespace {

using Text = std::array<char, 4096>;

std::string name_of_group(gid_t id) {
  group entry{};
  group* found = nullptr;
  Text text;
  const bool is_there = getgrgid_r(id, &entry, text.data(), text.size(), &found) == 0 && found != nullptr;
  return is_there ? found->gr_name : "";
}

bool is_listed_in(gid_t group, const passwd& user) {
  std::vector<gid_t> groups(16);
  int count = static_cast<int>(groups.size());
  // If `groups` is too small, the call returns the number of groups.
  while (getgrouplist(user.pw_name, user.pw_gid, groups.data(), &count) < 0)
    groups.resize(std::max(groups.size() + 1, static_cast<std::size_t>(count)));
  groups.resize(static_cast<std::size_t>(count));
  return std::ranges::find(groups, group) != groups.end();
}

}  // namespace

Membership Membership::of_this_process(gid_t group) {
  Membership membership{.group = name_of_group(group), .group_id = group};
  passwd entry{};
  passwd* found = nullptr;
  Text text;
  if (getpwuid_r(geteuid(), &entry, text.data(), text.size(), &found) != 0 || found == nullptr)
    return membership;
  membership.user = found->pw_name;
  membership.is_listed = is_listed_in(group, *found);
  return membership;
}

std::string how_to_join(const Membership& m) {
  if (m.group_id == 0)
    return "sftd serves the members of group root only; end it (sudo sftd stop) and start it by its service "
           "(sudo systemctl start sftd), or name another group in [access] of its configuration";
  const std::string id = std::to_string(m.group_id);
  if (m.group.empty() || m.user.empty())
    return "sftd serves the members of group " + (m.group.empty() ? id : m.group) +
           "; give this program that group (docker run --group-add " + id +
           ", or SupplementaryGroups= of a systemd unit)";
  if (m.is_listed)
    return "user " + m.user + " is a member of group " + m.group +
           ", which sftd serves, but not yet in this session; log out and in again, and start this program "
           "again";
  return "user " + m.user + " is no member of group " + m.group + ", which sftd serves; run: sudo adduser " +
         m.user + " " + m.group + ", log out and in again, and start this program again";
}

}  // namespace sft::shm
