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

tl::unexpected<Error> fail_on(const std::string& path) {
  const Errc code = errno == EACCES || errno == EPERM ? Errc::no_permission : Errc::system;
  return fail(code, path + ": " + std::strerror(errno));
}

tl::unexpected<Error> is_taken(const std::string& path) {
  return fail(Errc::address_in_use, path + " is locked");
}

/// Nobody else can open the new file, and so lock it, before it is locked and made readable.
/// (O_CREAT alone would not do: the kernel refuses it for another user's file in /tmp, fs.protected_regular.)
Descriptor create(const std::string& path) {
  return Descriptor(open(path.c_str(), O_RDWR | O_CLOEXEC | O_NOFOLLOW | O_CREAT | O_EXCL, 0600));
}

/// True if it is ours now.
bool lock(const Descriptor& file) {
  struct flock lock = whole_file(F_WRLCK);
  return fcntl(file.get(), F_OFD_SETLK, &lock) == 0;
}

bool is_new(const Descriptor& file) {
  struct stat opened {};
  return fstat(file.get(), &opened) == 0 && opened.st_uid == geteuid() && opened.st_size == 0;
}

/// What lies there is no living holder's: another account's file, something that is no file, what a dead
/// holder left, or a file that somebody has only locked for reading. Where this account may not remove it the
/// error says why the file is in the way.
Result<void> clear(const std::string& path, const Error& why) {
  if (unlink(path.c_str()) == 0 || errno == ENOENT) return {};
  if (rmdir(path.c_str()) == 0) return {};
  const std::string aside = path + "." + core::in_hex(core::random_id());
  if (geteuid() == 0 && rename(path.c_str(), aside.c_str()) == 0) return {};
  return fail(Errc::no_permission, why.message);
}

}  // namespace

/// To lock a file for reading takes no right but to read it, and everybody may: only a holder, who may write
/// it, has locked it for writing.
bool is_locked(int descriptor) noexcept {
  struct flock lock = whole_file(F_RDLCK);
  return fcntl(descriptor, F_OFD_GETLK, &lock) == 0 && lock.l_type != F_UNLCK;
}

bool is_locked_at(const char* path) noexcept {
  const auto file = core::open_trusted_file(path, O_RDONLY, {.everybody = true});
  return file && is_locked(file->get());
}

/// From here on others may look at it.
Result<FileLock> FileLock::publish(FileLock lock) {
  if (fchmod(lock.descriptor(), 0644) != 0) return fail_on(lock.path_);
  return lock;
}

Result<FileLock> FileLock::take(const std::string& path) {
  constexpr int attempts = 20;  // each one lost to another process that came or went at the same moment
  for (int i = 0; i < attempts; ++i) {
    if (Descriptor file = create(path)) {
      if (!lock(file) || !core::still_names(path, file.get())) continue;
      return publish(FileLock(path, std::move(file)));
    }
    if (errno != EEXIST) return fail_on(path);
    // One that a dead holder left is never reused: whoever still has it open would take us for that one.
    if (is_locked_at(path.c_str())) return is_taken(path);
    auto left = core::open_trusted_file(path, O_RDWR);
    if (!left) {
      if (left.error().code == Errc::unavailable) continue;
      if (auto cleared = clear(path, left.error()); !cleared) return tl::unexpected(cleared.error());
      continue;
    }
    // Of those that come here at the same time only the one that has the lock removes the file. Where a
    // stranger's lock for reading is in the way, the file itself is all that tells.
    const bool locked = lock(*left);
    if (!locked && is_locked(left->get())) return is_taken(path);
    if (!core::still_names(path, left->get())) continue;
    // Another one that starts has just made it, and comes too late.
    if (locked && is_new(*left)) return publish(FileLock(path, std::move(*left)));
    if (unlink(path.c_str()) != 0 && errno != ENOENT) return fail_on(path);
  }
  return fail(Errc::address_in_use, path + " keeps changing hands");
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
