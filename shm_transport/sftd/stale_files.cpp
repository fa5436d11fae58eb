#include "shm_transport/sftd/stale_files.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <system_error>

#include "shm_transport/host_file.h"
#include "shm_transport/iceoryx.h"
#include "shm_transport/sftd/status_file.h"

namespace sft::shm {

bool remove_socket(const std::string& path) {
  struct stat named {};
  return lstat(path.c_str(), &named) == 0 && S_ISSOCK(named.st_mode) && unlink(path.c_str()) == 0;
}

std::size_t remove_dead_sockets() {
  std::size_t removed = 0;
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator("/tmp", ignored)) {
    if (!is_runtime_name(entry.path().filename().string())) continue;
    if (listener_at(entry.path().c_str()) == Listener::gone && remove_socket(entry.path())) ++removed;
  }
  return removed;
}

void remove_segment_of_the_dead() {
  const Descriptor sign(open(host_file_path, O_RDONLY | O_CLOEXEC | O_NOFOLLOW));
  if (!sign || is_locked(sign.get())) return;
  char text[1024];
  const ssize_t bytes = read(sign.get(), text, sizeof text);
  const auto file = parse_host_file({text, static_cast<std::size_t>(std::max<ssize_t>(bytes, 0))});
  if (!file || file->segment.empty() || file->segment.find('/') != std::string::npos) return;
  // Everybody can write into /dev/shm: the sign speaks only for files of its own user.
  struct stat written {};
  struct stat named {};
  const bool same_user = fstat(sign.get(), &written) == 0 &&
                         stat(("/dev/shm/" + file->segment).c_str(), &named) == 0 &&
                         written.st_uid == named.st_uid;
  if (same_user) shm_unlink(("/" + file->segment).c_str());
}

void remove_daemon_files(const std::string& segment_name) {
  shm_unlink((std::string("/") + iox::roudi::SHM_NAME).c_str());
  shm_unlink(("/" + segment_name).c_str());
  const std::string lock_suffix = ".lock";
  remove_status_file();
  unlink(roudi_socket_path);
  unlink((roudi_socket_path + lock_suffix).c_str());
  unlink(("/tmp/" + std::string(iox::roudi::ROUDI_LOCK_NAME) + lock_suffix).c_str());
}

}  // namespace sft::shm
