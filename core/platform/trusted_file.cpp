#include "core/platform/trusted_file.h"

#include <fcntl.h>
#include <pwd.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

namespace sft::core {

namespace {

const char* kind_of(const struct stat& file) {
  switch (file.st_mode & S_IFMT) {
    case S_IFIFO:
      return "a FIFO";
    case S_IFDIR:
      return "a directory";
    case S_IFLNK:
      return "a symbolic link";
    case S_IFSOCK:
      return "a socket";
    case S_IFREG:
      return "a file";
    default:
      return "a device";
  }
}

std::string remedy(const std::string& path, const struct stat& file) {
  return std::string("remove it: ") + (S_ISDIR(file.st_mode) ? "rm -r " : "rm ") + path + " (as " +
         (file.st_uid == 0 ? "root)" : "root or " + account_name(file.st_uid) + ")");
}

tl::unexpected<Error> refuse(const std::string& path, const struct stat& file, const std::string& why) {
  return fail(Errc::address_in_use, path + ": " + why + "; " + remedy(path, file));
}

/// Returns the error for a path that could not be opened as a file. `error` is the error number.
tl::unexpected<Error> refuse_unopened(const std::string& path, int error) {
  struct stat there {};
  if (error == ENOENT || lstat(path.c_str(), &there) != 0)
    return fail(Errc::unavailable, path + ": " + std::strerror(error));
  if (!S_ISREG(there.st_mode))
    return refuse(
        path, there,
        std::string("it is ") + kind_of(there) + " of " + account_name(there.st_uid) + " and not a file");
  const bool forbidden = error == EACCES || error == EPERM;
  return fail(forbidden ? Errc::no_permission : Errc::system,
              path + " (of " + account_name(there.st_uid) + "): " + std::strerror(error));
}

}  // namespace

bool TrustedAccounts::include_user(uid_t user) const {
  return everybody || user == 0 || user == geteuid() || std::ranges::find(users, user) != users.end();
}

bool TrustedAccounts::include_owner_of(const struct stat& file) const {
  return include_user(file.st_uid) || std::ranges::find(groups, file.st_gid) != groups.end();
}

Result<FileDescriptor> open_trusted_file(const std::string& path, int access,
                                         const TrustedAccounts& accounts) {
  FileDescriptor file(open(path.c_str(), access | O_NONBLOCK | O_NOFOLLOW | O_CLOEXEC | O_NOCTTY));
  if (!file) return refuse_unopened(path, errno);
  struct stat opened {};
  if (fstat(file.get(), &opened) != 0) return fail(Errc::system, path + ": " + std::strerror(errno));
  if (!S_ISREG(opened.st_mode))
    return refuse(
        path, opened,
        std::string("it is ") + kind_of(opened) + " of " + account_name(opened.st_uid) + " and not a file");
  if (!accounts.include_owner_of(opened))
    return refuse(path, opened,
                  "it belongs to " + account_name(opened.st_uid) + ", whose files are not accepted here");
  if (opened.st_nlink > 1) return refuse(path, opened, "it has a second name, and may be any other file");
  return file;
}

std::string account_name(uid_t user) {
  passwd entry{};
  passwd* found = nullptr;
  std::array<char, 4096> text;
  if (getpwuid_r(user, &entry, text.data(), text.size(), &found) != 0 || found == nullptr)
    return "user " + std::to_string(user);
  return std::string("user ") + found->pw_name;
}

bool still_names(const std::string& path, int descriptor) noexcept {
  struct stat named {};
  struct stat opened {};
  return lstat(path.c_str(), &named) == 0 && fstat(descriptor, &opened) == 0 &&
         named.st_dev == opened.st_dev && named.st_ino == opened.st_ino;
}

}  // namespace sft::core
