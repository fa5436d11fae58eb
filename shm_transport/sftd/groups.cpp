#include "shm_transport/sftd/groups.h"

#include <grp.h>
#include <pwd.h>
#include <unistd.h>

namespace sft::shm {

namespace {

Result<gid_t> id_of(const std::string& name) {
  if (const group* found = getgrnam(name.c_str()); found != nullptr) return found->gr_gid;
  return fail(Errc::invalid_argument,
              "group " + name +
                  ", named in [access] of the configuration, does not exist; create it "
                  "(groupadd --system " +
                  name + ") or name another group");
}

Result<void> become(const std::string& name) {
  const auto id = id_of(name);
  if (!id) return tl::unexpected(id.error());
  if (getegid() == *id || setegid(*id) == 0) return {};
  return fail(Errc::no_permission,
              "sftd may not run as group " + name +
                  ", which is to publish; start it as that group (Group= of a systemd unit, "
                  "or sg), or as root");
}

bool is_listed(const group& members, const std::string& user) {
  for (char** member = members.gr_mem; *member != nullptr; ++member) {
    if (user == *member) return true;
  }
  return false;
}

/// Returns a member of the group, preferably the user that this process runs as.
std::optional<uid_t> member_of(const group& members) {
  const gid_t id = members.gr_gid;
  std::optional<uid_t> found;
  setpwent();
  while (const passwd* user = getpwent()) {
    const bool is_member = user->pw_gid == id || is_listed(members, user->pw_name);
    if (is_member && (!found || user->pw_uid == geteuid())) found = user->pw_uid;
  }
  endpwent();
  return found;
}

std::string name_of_own_user() {
  const passwd* user = getpwuid(geteuid());
  return user == nullptr ? std::to_string(geteuid()) : user->pw_name;
}

}  // namespace

Result<Groups> take_up_groups(const AccessSettings& settings) {
  if (!settings.writers.empty()) {
    if (auto became = become(settings.writers); !became) return tl::unexpected(became.error());
  }
  const group* own = getgrgid(getegid());
  if (own == nullptr) {
    return fail(Errc::no_permission,
                "group " + std::to_string(getegid()) +
                    " has no entry in /etc/group; iceoryx needs one to give access to the memory; add it");
  }
  Groups groups;
  groups.writers = own->gr_name;
  const auto member = member_of(*own);
  if (!member) {
    return fail(Errc::no_permission,
                "group " + groups.writers +
                    " has no members in /etc/group, and iceoryx needs one; add the user that sftd runs as: "
                    "sudo adduser " +
                    name_of_own_user() + " " + groups.writers);
  }
  groups.member = *member;
  if (settings.readers.empty() || settings.readers == groups.writers) return groups;
  const auto readers = id_of(settings.readers);
  if (!readers) return tl::unexpected(readers.error());
  groups.readers = settings.readers;
  groups.reader_id = *readers;
  return groups;
}

}  // namespace sft::shm
