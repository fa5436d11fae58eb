#include "shm_transport/host/access.h"

#include <fcntl.h>
#include <sys/acl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <memory>
#include <type_traits>

#include "core/platform/file_descriptor.h"

namespace sft::shm {

namespace {

struct Free {
  void operator()(void* memory) const { acl_free(memory); }
};
using Qualifier = std::unique_ptr<id_t, Free>;

tl::unexpected<Error> access_failure(const std::string& path) {
  return fail(errno == EOPNOTSUPP ? Errc::unavailable : Errc::no_permission,
              path + ": its access control list: " + std::strerror(errno));
}

bool is_for(acl_entry_t entry, acl_tag_t tag, id_t id) {
  acl_tag_t its_tag{};
  if (acl_get_tag_type(entry, &its_tag) != 0 || its_tag != tag) return false;
  const Qualifier its_id(static_cast<id_t*>(acl_get_qualifier(entry)));
  return its_id != nullptr && *its_id == id;
}

/// Returns the entry of the user or group, and adds an entry if there is none. Returns null if the entry
/// could not be added.
acl_entry_t entry_for(acl_t& list, acl_tag_t tag, id_t id) {
  acl_entry_t entry{};
  for (int more = acl_get_entry(list, ACL_FIRST_ENTRY, &entry); more == 1;
       more = acl_get_entry(list, ACL_NEXT_ENTRY, &entry)) {
    if (is_for(entry, tag, id)) return entry;
  }
  const bool made = acl_create_entry(&list, &entry) == 0 && acl_set_tag_type(entry, tag) == 0 &&
                    acl_set_qualifier(entry, &id) == 0;
  return made ? entry : nullptr;
}

Result<void> grant(const std::string& path, acl_tag_t tag, id_t id) {
  static_assert(std::is_same_v<id_t, uid_t> && std::is_same_v<id_t, gid_t>);
  // Another account may put a link at this path at any moment. So the path is resolved only once, and both
  // the check and the change use the same descriptor.
  const core::FileDescriptor descriptor(open(path.c_str(), O_PATH | O_NOFOLLOW | O_CLOEXEC));
  struct stat file {};
  if (!descriptor || fstat(descriptor.get(), &file) != 0) return access_failure(path);
  if (file.st_uid != geteuid() || S_ISLNK(file.st_mode))
    return fail(Errc::no_permission, path + " does not belong to this account any more");
  const std::string opened = "/proc/self/fd/" + std::to_string(descriptor.get());
  acl_t list = acl_get_file(opened.c_str(), ACL_TYPE_ACCESS);
  if (list == nullptr) return access_failure(path);
  acl_permset_t rights{};
  const acl_entry_t entry = entry_for(list, tag, id);
  const bool granted = entry != nullptr && acl_get_permset(entry, &rights) == 0 &&
                       acl_add_perm(rights, ACL_READ) == 0 && acl_add_perm(rights, ACL_WRITE) == 0 &&
                       acl_calc_mask(&list) == 0 && acl_set_file(opened.c_str(), ACL_TYPE_ACCESS, list) == 0;
  const int error = errno;
  acl_free(list);
  errno = error;
  return granted ? Result<void>{} : access_failure(path);
}

}  // namespace

Result<void> grant_to_user(const std::string& path, uid_t user) { return grant(path, ACL_USER, user); }

Result<void> grant_to_group(const std::string& path, gid_t group) { return grant(path, ACL_GROUP, group); }

}  // namespace sft::shm
