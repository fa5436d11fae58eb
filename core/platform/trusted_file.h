// Opens files in directories to which every account of the host can write (/dev/shm, /tmp). At a path
// there, another account may have put a FIFO, which would block the thread that opens it, a link to a file
// of this account, a file with forged contents, or a file that it truncates once the file is mapped. So
// such paths are opened only by open_trusted_file(). This function never waits and follows no link. It
// accepts only regular files that have a single name and belong to a trusted account.
#pragma once

#include <sys/stat.h>
#include <sys/types.h>

#include <string>
#include <vector>

#include "core/platform/file_descriptor.h"
#include "sft/result.h"

namespace sft::core {

/// The accounts whose files are accepted. Root and the account of this process are always accepted.
struct TrustedAccounts {
  std::vector<uid_t> users{};
  /// Files of these groups are accepted, too. Only a member of a group can give a file to that group.
  std::vector<gid_t> groups{};
  bool everybody = false;  ///< true: files of all accounts; for commands that only display them

  bool include_user(uid_t user) const;
  bool include_owner_of(const struct stat& file) const;
  friend bool operator==(const TrustedAccounts&, const TrustedAccounts&) = default;
};

/// Opens an existing file of one of these accounts. `access` is O_RDONLY or O_RDWR. Returns
/// Errc::unavailable if there is no such file, Errc::address_in_use if the path is not a regular file with
/// one name, or if the file belongs to another account, and Errc::no_permission if this account must not
/// open the file. The error names the file, its owner, and what to do.
Result<FileDescriptor> open_trusted_file(const std::string& path, int access,
                                         const TrustedAccounts& accounts = {});

/// Returns "user alice", or "user 1234" if the user has no name.
std::string account_name(uid_t user);

/// Returns true if the path still names the open file, which may have been removed or replaced.
bool still_names(const std::string& path, int descriptor) noexcept;

}  // namespace sft::core
