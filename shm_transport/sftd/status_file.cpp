#include "shm_transport/sftd/status_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>

#include "core/trusted_file.h"
#include "shm_transport/file_lock.h"

namespace sft::shm {

namespace {

constexpr const char* path = "/dev/shm/sft_status";
constexpr const char* next_path = "/dev/shm/sft_status.next";
constexpr std::size_t largest_bytes = 16 << 20;

tl::unexpected<Error> fail_on_next() {
  return fail(Errc::system, std::string(next_path) + ": " + std::strerror(errno));
}

bool write_all(int file, std::string_view text) {
  while (!text.empty()) {
    const ssize_t written = write(file, text.data(), text.size());
    if (written <= 0) return false;
    text.remove_prefix(static_cast<std::size_t>(written));
  }
  return true;
}

}  // namespace

Result<void> write_status_file(const Status& status) {
  unlink(next_path);  // of a daemon that was killed while it wrote
  const Descriptor file(open(next_path, O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644));
  if (!file || !write_all(file.get(), to_json(status)) || rename(next_path, path) != 0) return fail_on_next();
  return {};
}

std::optional<Status> read_status_file(uid_t daemon_user) {
  const auto file = core::open_trusted_file(path, O_RDONLY, {.users = {daemon_user}});
  struct stat written {};
  if (!file || fstat(file->get(), &written) != 0 || written.st_uid != daemon_user) return std::nullopt;
  if (static_cast<std::size_t>(written.st_size) > largest_bytes) return std::nullopt;
  std::string text(static_cast<std::size_t>(written.st_size), '\0');
  const ssize_t bytes = pread(file->get(), text.data(), text.size(), 0);
  return bytes == written.st_size ? parse_status(text) : std::nullopt;
}

void remove_status_file() noexcept {
  unlink(next_path);
  unlink(path);
}

}  // namespace sft::shm
