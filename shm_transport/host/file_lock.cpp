#include "shm_transport/host/file_lock.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "core/platform/random_id.h"
#include "core/platform/trusted_file.h"

namespace sft::shm {

namespace {

struct flock whole_file(short type) {
  struct flock lock {};
  lock.l_type = type;
  lock.l_whence = SEEK_SET;
  return lock;
}

tl::unexpected<Error> lock_failure(const std::string& path) {
  const Errc code = errno == EACCES || errno == EPERM ? Errc::no_permission : Errc::system;
  return fail(code, path + ": " + std::strerror(errno));
}

tl::unexpected<Error> is_taken(const std::string& path) {
  return fail(Errc::address_in_use, path + " is locked");
}

/// Makes a new file with mode 0600, so that no other account can open and lock it before this process has
/// locked it and made it readable. (O_CREAT without O_EXCL would not be enough: with fs.protected_regular
/// the kernel refuses it for a file of another user in /tmp.)
Descriptor create(const std::string& path) {
  return Descriptor(open(path.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_CREAT | O_EXCL, 0600));
}

/// Tries to lock the file for writing. Returns whether this process has the lock now.
bool lock(const Descriptor& file) {
  struct flock lock = whole_file(F_WRLCK);
  return fcntl(file.get(), F_OFD_SETLK, &lock) == 0;
}

bool is_new(const Descriptor& file) {
  struct stat opened {};
  return fstat(file.get(), &opened) == 0 && opened.st_uid == geteuid() && opened.st_size == 0;
}

/// Removes a file that no living holder has locked: a file of another account, something that is no regular
/// file, a file that a dead holder left, or a file that is only locked for reading. If this account may not
/// remove the file, the error says why the file is in the way.
Result<void> clear_path(const std::string& path, const Error& why) {
  if (unlink(path.c_str()) == 0 || errno == ENOENT) return {};
  if (rmdir(path.c_str()) == 0) return {};
  const std::string aside = path + "." + core::in_hex(core::random_id());
  if (geteuid() == 0 && rename(path.c_str(), aside.c_str()) == 0) return {};
  return fail(Errc::no_permission, why.message);
}

}  // namespace

/// Queries whether a read lock could be taken, which only a write lock prevents. Every account may read the
/// file, and so may lock it for reading. Only the holder of the lock may write the file, and the holder has
/// locked the file for writing.
bool is_locked(int descriptor) noexcept {
  struct flock lock = whole_file(F_RDLCK);
  return fcntl(descriptor, F_OFD_GETLK, &lock) == 0 && lock.l_type != F_UNLCK;
}

bool is_locked_at(const char* path) noexcept {
  const auto file = core::open_trusted_file(path, O_RDONLY, {.everybody = true});
  return file && is_locked(file->get());
}

/// Makes the file readable for every account, so that other processes see the lock from now on.
Result<FileLock> FileLock::publish(FileLock lock) {
  if (fchmod(lock.descriptor(), 0644) != 0) return lock_failure(lock.path_);
  return lock;
}

Result<FileLock> FileLock::take(const std::string& path) {
  constexpr int attempts = 20;  // an attempt fails if another process creates or removes the file meanwhile
  for (int i = 0; i < attempts; ++i) {
    if (Descriptor file = create(path)) {
      if (!lock(file) || !core::still_names(path, file.get())) continue;
      return publish(FileLock(path, std::move(file)));
    }
    if (errno != EEXIST) return lock_failure(path);
    // The file of a dead holder is never reused: a process that still has it open would take this process for
    // the dead one.
    if (is_locked_at(path.c_str())) return is_taken(path);
    auto leftover = core::open_trusted_file(path, O_RDWR);
    if (!leftover) {
      if (leftover.error().code == Errc::unavailable) continue;
      if (auto cleared = clear_path(path, leftover.error()); !cleared) return tl::unexpected(cleared.error());
      continue;
    }
    // If several processes find the file of a dead holder at the same time, only the process that gets the
    // lock removes the file. While another account has locked the file for reading, no process gets the
    // lock. In that case the file is removed without the lock, if the path still names that file.
    const bool locked = lock(*leftover);
    if (!locked && is_locked(leftover->get())) return is_taken(path);
    if (!core::still_names(path, leftover->get())) continue;
    // Another process that starts has just made a new file. This process has locked the new file first and
    // keeps it.
    if (locked && is_new(*leftover)) return publish(FileLock(path, std::move(*leftover)));
    if (unlink(path.c_str()) != 0 && errno != ENOENT) return lock_failure(path);
  }
  return fail(Errc::address_in_use, path + " was taken and left by other processes at each of " +
                                        std::to_string(attempts) + " attempts");
}

bool FileLock::is_named() const noexcept { return !path_.empty() && core::still_names(path_, file_.get()); }

void FileLock::unlock() noexcept {
  struct flock none = whole_file(F_UNLCK);
  fcntl(file_.get(), F_OFD_SETLK, &none);
}

void FileLock::remove() noexcept {
  if (file_ && is_named()) unlink(path_.c_str());
  path_.clear();
}

}  // namespace sft::shm
