#include "shm_transport/file_lock.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace sft::shm {

namespace {

struct flock whole_file() {
  struct flock lock {};
  lock.l_type = F_WRLCK;
  lock.l_whence = SEEK_SET;
  return lock;
}

/// Whether the path still names the file that is open; a former holder may have removed it in between.
bool still_named(const std::string& path, const struct stat& opened) {
  struct stat named {};
  return stat(path.c_str(), &named) == 0 && named.st_dev == opened.st_dev && named.st_ino == opened.st_ino;
}

tl::unexpected<Error> fail_on(const std::string& path) {
  const Errc code = errno == EACCES || errno == EPERM ? Errc::no_permission : Errc::system;
  return fail(code, path + ": " + std::strerror(errno));
}

/// Not with O_CREAT alone, which the kernel refuses for another user's file in /tmp (fs.protected_regular).
Descriptor open_or_create(const std::string& path) {
  constexpr int flags = O_RDWR | O_CLOEXEC | O_NOFOLLOW;
  Descriptor existing(open(path.c_str(), flags));
  if (existing || errno != ENOENT) return existing;
  return Descriptor(open(path.c_str(), flags | O_CREAT | O_EXCL, 0644));
}

}  // namespace

bool is_locked(int descriptor) noexcept {
  struct flock lock = whole_file();
  return fcntl(descriptor, F_OFD_GETLK, &lock) == 0 && lock.l_type != F_UNLCK;
}

bool is_locked_at(const char* path) noexcept {
  const Descriptor file(open(path, O_RDONLY | O_CLOEXEC | O_NOFOLLOW));
  return file && is_locked(file.get());
}

Result<FileLock> FileLock::take(const std::string& path) {
  constexpr int attempts = 20;  // each one lost to another process that came or went at the same moment
  for (int i = 0; i < attempts; ++i) {
    Descriptor file = open_or_create(path);
    if (!file) {
      const int error = errno;
      if (error == EEXIST) continue;
      // Of another user, whose file may be neither written nor removed.
      if (is_locked_at(path.c_str())) return fail(Errc::address_in_use, path + " is locked");
      errno = error;
      return fail_on(path);
    }
    struct flock lock = whole_file();
    if (fcntl(file.get(), F_OFD_SETLK, &lock) != 0) {
      if (errno == EAGAIN || errno == EACCES) return fail(Errc::address_in_use, path + " is locked");
      return fail_on(path);
    }
    struct stat opened {};
    if (fstat(file.get(), &opened) != 0) return fail_on(path);
    if (!still_named(path, opened)) continue;
    if (opened.st_size == 0) return FileLock(path, std::move(file));
    // Left by a dead holder. Removing it is safe: nobody else can have the lock that we hold.
    if (unlink(path.c_str()) != 0 && errno != ENOENT) return fail_on(path);
  }
  return fail(Errc::address_in_use, path + " keeps changing hands");
}

void FileLock::remove() noexcept {
  if (file_ && !path_.empty()) unlink(path_.c_str());
  path_.clear();
}

}  // namespace sft::shm
