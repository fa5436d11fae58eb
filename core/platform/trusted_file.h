// Files in directories that every account of the host can write to (/dev/shm, /tmp). Another account may have
// put anything at a path there before us: a FIFO, which would block who opens it, a link to a file of ours, a
// file whose words are lies, or one that it truncates once it is mapped. So such a path is opened in one way
// only: the call never waits and follows no link, and what was opened is believed only if it is a regular
// file with one name, of an account that is trusted.
#pragma once

#include <sys/stat.h>
#include <sys/types.h>

#include <string>
#include <vector>

#include "core/platform/file_descriptor.h"
#include "sft/result.h"

namespace sft::core {

/// The accounts whose files are believed. Root and this process's own account always are among them.
struct TrustedAccounts {
  std::vector<uid_t> users{};
  /// Only a member of a group can give a file to that group: such a file is by one of its members.
  std::vector<gid_t> groups{};
  bool everybody = false;  ///< for commands that only show what is there

  bool include_user(uid_t user) const;
  bool include_owner_of(const struct stat& file) const;
  friend bool operator==(const TrustedAccounts&, const TrustedAccounts&) = default;
};

/// Opens an existing file of one of these accounts. `access` is O_RDONLY or O_RDWR. Errc::unavailable if
/// there is none, Errc::address_in_use if something else is in its place or it is of another account,
/// Errc::no_permission if this account may not open it. The error names the file, its owner, and what to do.
Result<FileDescriptor> open_trusted_file(const std::string& path, int access,
                                         const TrustedAccounts& accounts = {});

/// "user alice", or "user 1234" where that has no name.
std::string account_name(uid_t user);

/// Returns true if the path still names the open file: somebody may have removed or replaced it.
bool still_names(const std::string& path, int descriptor) noexcept;

}  // namespace sft::core
