#include "shm_transport/sftd/segment_file.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

namespace sft::shm {

namespace {

constexpr mode_t owner_and_group = S_IRUSR | S_IWUSR | S_IRGRP | S_IWGRP;

std::string path_of(const std::string& name) { return "/dev/shm/" + name; }

}  // namespace

std::vector<FilePart> SegmentFile::at_once() const {
  std::vector<FilePart> parts;
  std::size_t at = 0;
  for (const FilePart& part : on_demand) {
    if (part.offset > at) parts.push_back({at, part.offset - at});
    at = part.offset + part.bytes;
  }
  if (at < bytes) parts.push_back({at, bytes - at});
  return parts;
}

Result<SegmentFile> make_segment_file_without_memory(const std::string& name, std::size_t bytes) {
  core::FileDescriptor file(
      shm_open(("/" + name).c_str(), O_RDWR | O_CREAT | O_EXCL | O_NOFOLLOW | O_CLOEXEC, S_IRUSR | S_IWUSR));
  if (!file) {
    const bool exists = errno == EEXIST;
    return fail(exists ? Errc::address_in_use : Errc::out_of_memory,
                path_of(name) + " could not be made: " + std::strerror(errno));
  }
  if (ftruncate(file.get(), static_cast<off_t>(bytes)) == 0 && fchmod(file.get(), owner_and_group) == 0)
    return SegmentFile{.file = std::move(file), .bytes = bytes};
  const int error = errno;
  shm_unlink(("/" + name).c_str());
  return fail(Errc::out_of_memory, path_of(name) + " could not be given its size: " + std::strerror(error));
}

Result<void> set_aside(const SegmentFile& segment, const std::string& name) {
  for (const FilePart& part : segment.at_once()) {
    int error = 0;
    do
      error = posix_fallocate(segment.file.get(), static_cast<off_t>(part.offset),
                              static_cast<off_t>(part.bytes));
    while (error == EINTR);
    if (error == 0) continue;
    return fail(Errc::out_of_memory, path_of(name) + " could not be given " + std::to_string(part.bytes) +
                                         " bytes: " + std::strerror(error));
  }
  return {};
}

Result<SegmentFile> make_segment_file(const std::string& name, std::size_t bytes) {
  auto segment = make_segment_file_without_memory(name, bytes);
  if (!segment) return segment;
  const auto done = set_aside(*segment, name);
  if (done) return segment;
  shm_unlink(("/" + name).c_str());
  return tl::unexpected(done.error());
}

/// Sets the pages aside once more, which clears a page that was set aside before (shmem_get_folio_gfp() in
/// Linux). The size is checked, because pages beyond the end of a truncated file would be set aside in
/// vain.
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
