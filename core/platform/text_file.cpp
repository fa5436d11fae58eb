#include "core/platform/text_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstddef>
#include <cstring>

#include "core/platform/file_descriptor.h"

namespace sft::core {

namespace {
constexpr std::size_t text_bytes_max = 1 << 20;

tl::unexpected<Error> refused(const std::string& path, const std::string& why) {
  return fail(Errc::unavailable, path + ": " + why);
}
}  // namespace

Result<std::string> read_text_file(const std::string& path) {
  const FileDescriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOCTTY));
  if (!file) return refused(path, std::strerror(errno));
  struct stat kind {};
  if (::fstat(file.get(), &kind) != 0) return refused(path, std::strerror(errno));
  if (!S_ISREG(kind.st_mode))
    return refused(
        path, S_ISDIR(kind.st_mode) ? "this is a directory, not a text file" : "this is not a text file");
  std::string text(text_bytes_max + 1, '\0');
  std::size_t size = 0;
  while (size < text.size()) {
    const ssize_t bytes = ::read(file.get(), text.data() + size, text.size() - size);
    if (bytes < 0 && errno == EINTR) continue;
    if (bytes < 0) return refused(path, std::strerror(errno));
    if (bytes == 0) break;
    size += static_cast<std::size_t>(bytes);
  }
  if (size > text_bytes_max) return refused(path, "this is longer than 1 MiB");
  text.resize(size);
  return text;
}

}  // namespace sft::core
