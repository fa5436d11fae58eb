#include "shm_transport/sftd/segment_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace sft::shm {

namespace {

constexpr mode_t owner_and_group = S_IRUSR | S_IWUSR | S_IRGRP | S_IWGRP;

/// Returns the error number, or 0.
int set_aside(const core::FileDescriptor& file, std::size_t bytes) {
  int error = 0;
  do error = posix_fallocate(file.get(), 0, static_cast<off_t>(bytes));
  while (error == EINTR);
  return error;
}

}  // namespace

Result<SegmentFile> make_segment_file(const std::string& name, std::size_t bytes) {
  const std::string path = "/dev/shm/" + name;
  core::FileDescriptor file(
      shm_open(("/" + name).c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, S_IRUSR | S_IWUSR));
  if (!file) {
    const bool exists = errno == EEXIST;
    return fail(exists ? Errc::address_in_use : Errc::out_of_memory,
                path + " could not be made: " + std::strerror(errno));
  }
  int error = set_aside(file, bytes);
  if (error == 0 && fchmod(file.get(), owner_and_group) != 0) error = errno;
  if (error == 0) return SegmentFile{std::move(file), bytes};
  shm_unlink(("/" + name).c_str());
  return fail(Errc::out_of_memory,
              path + " could not be given " + std::to_string(bytes) + " bytes: " + std::strerror(error));
}

/// A page that was set aside before is cleared when it is set aside again (shmem_get_folio_gfp() in Linux).
/// Behind the end of a file that somebody has made shorter, pages would be set aside for nobody.
bool clear_pages(const SegmentFile& segment, std::size_t offset, std::size_t bytes) {
  struct stat now {};
  if (fstat(segment.file.get(), &now) != 0 || static_cast<std::size_t>(now.st_size) < offset + bytes)
    return false;
  int failed = 0;
  do
    failed = fallocate(segment.file.get(), FALLOC_FL_KEEP_SIZE, static_cast<off_t>(offset),
                       static_cast<off_t>(bytes));
  while (failed != 0 && errno == EINTR);
  return failed == 0;
}

}  // namespace sft::shm
