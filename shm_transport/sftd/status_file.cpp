#include "shm_transport/sftd/status_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <exception>
#include <filesystem>
#include <string>
#include <string_view>

#include "core/platform/random_id.h"
#include "core/platform/trusted_file.h"
#include "shm_transport/host/file_lock.h"

namespace sft::shm {

namespace {

constexpr const char* path = "/dev/shm/sft_status";
constexpr std::string_view next_prefix = "sft_status.";
constexpr std::size_t largest_bytes = 16 << 20;

/// Returns a new random name at each call, so that no other process has a file with this name.
std::string next_path() { return std::string(path) + "." + core::in_hex(core::random_id()); }

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
  const std::string next = next_path();
  const Descriptor file(open(next.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0644));
  if (file && write_all(file.get(), to_json(status)) && rename(next.c_str(), path) == 0) return {};
  const std::string why = std::strerror(errno);
  if (file) unlink(next.c_str());
  return fail(Errc::system, std::string(path) + ": " + why);
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

/// Removes the status file, and the unfinished file that a killed daemon may have left. /dev/shm is sticky,
/// so files of other accounts stay.
void remove_status_file() noexcept try {
  unlink(path);
  for (const auto& entry : std::filesystem::directory_iterator("/dev/shm")) {
    if (entry.path().filename().string().starts_with(next_prefix)) unlink(entry.path().c_str());
  }
} catch (const std::exception&) {  // the file stays, and does no harm
}

}  // namespace sft::shm
