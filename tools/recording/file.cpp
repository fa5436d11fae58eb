#include "tools/recording/file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <system_error>
#include <utility>

namespace sft::recording {

namespace {

constexpr std::size_t window_bytes = std::size_t{1} << 16;

/// Reads bytes, and returns their number. The number is smaller than requested at the end of the file, or
/// after an error, which is in errno.
std::size_t read_at(int descriptor, std::uint64_t offset, std::span<std::byte> to) {
  std::size_t done = 0;
  errno = 0;
  while (done < to.size()) {
    const ssize_t bytes =
        pread(descriptor, to.data() + done, to.size() - done, static_cast<off_t>(offset + done));
    if (bytes < 0 && errno == EINTR) continue;
    if (bytes <= 0) break;
    done += static_cast<std::size_t>(bytes);
  }
  return done;
}

}  // namespace

Result<File> File::open(const std::string& path) {
  // Without O_NONBLOCK, opening a FIFO would wait for a writer. For regular files, the flag has no effect.
  const int descriptor = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  struct stat about {};
  if (descriptor < 0 || fstat(descriptor, &about) != 0 || !S_ISREG(about.st_mode)) {
    const int code = about.st_mode == 0 ? errno : 0;
    if (descriptor >= 0) ::close(descriptor);
    const std::string why = code != 0                ? std::generic_category().message(code)
                            : S_ISDIR(about.st_mode) ? std::generic_category().message(EISDIR)
                                                     : "it is no file with contents";
    return fail(code == ENOENT ? Errc::unavailable : Errc::system, "'" + path + "' cannot be read: " + why);
  }
  return File(descriptor, static_cast<std::uint64_t>(about.st_size), path);
}

File::File(File&& other) noexcept
    : descriptor_(std::exchange(other.descriptor_, -1)), size_(other.size_), name_(std::move(other.name_)) {}

File::~File() {
  if (descriptor_ >= 0) ::close(descriptor_);
}

std::span<const std::byte> File::look(std::uint64_t offset, std::size_t length) {
  const bool is_there = offset >= window_at_ && offset - window_at_ <= window_.size() &&
                        window_.size() - (offset - window_at_) >= length;
  if (!is_there) {
    window_.resize(std::max(length, window_bytes));
    window_at_ = offset;
    window_.resize(read_at(descriptor_, offset, window_));
  }
  const auto found = std::span(window_).subspan(static_cast<std::size_t>(offset - window_at_));
  return found.first(std::min(length, found.size()));
}

Result<Bytes> File::read(std::uint64_t offset, std::uint64_t length) const {
  if (offset > size_ || length > size_ - offset) return fail(Errc::malformed, "the file ends before its end");
  Bytes bytes(static_cast<std::size_t>(length));
  if (read_at(descriptor_, offset, bytes) == bytes.size()) return bytes;
  return fail(Errc::system, errno == 0
                                ? "the file became shorter while it was read"
                                : "the system cannot read it: " + std::generic_category().message(errno));
}

}  // namespace sft::recording
