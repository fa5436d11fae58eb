#include "shm_transport/sftd/stale_files.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdio>
#include <filesystem>
#include <iterator>
#include <system_error>

#include "core/platform/random_id.h"
#include "core/platform/trusted_file.h"
#include "shm_transport/daemon/launch_obstacles.h"
#include "shm_transport/host/host_file.h"
#include "shm_transport/sftd/status_file.h"

namespace sft::shm {

namespace {

/// Removes the file or directory, or moves it aside if root runs this. Returns whether the path is free
/// now.
bool remove(const std::string& path) {
  if (unlink(path.c_str()) == 0 || errno == ENOENT || rmdir(path.c_str()) == 0) return true;
  const std::string aside = path + "." + core::in_hex(core::random_id());
  return geteuid() == 0 && rename(path.c_str(), aside.c_str()) == 0;
}

}  // namespace

bool remove_socket(const std::string& path) {
  struct stat named {};
  return lstat(path.c_str(), &named) == 0 && S_ISSOCK(named.st_mode) && unlink(path.c_str()) == 0;
}

void remove_dead_sockets() {
  std::error_code ignored;
  for (const auto& entry : std::filesystem::directory_iterator("/tmp", ignored)) {
    const std::string path = entry.path();
    if (is_runtime_name(entry.path().filename().string()) &&
        socket_state_at(path.c_str()) == SocketState::gone)
      remove_socket(path);
  }
}

void remove_segment_of_the_dead() {
  const auto host_file = core::open_trusted_file(host_file_path, O_RDONLY, {.everybody = true});
  if (!host_file || is_locked(host_file->get())) return;
  char text[1024];
  const ssize_t bytes = read(host_file->get(), text, sizeof text);
  const auto file = parse_host_file({text, static_cast<std::size_t>(std::max<ssize_t>(bytes, 0))});
  if (!file || file->segment.empty() || file->segment.find('/') != std::string::npos) return;
  // Every account can write into /dev/shm. So the name of a segment in a host file is trusted only if the
  // same user owns both files.
  struct stat written {};
  struct stat named {};
  const bool same_user = fstat(host_file->get(), &written) == 0 &&
                         lstat(("/dev/shm/" + file->segment).c_str(), &named) == 0 &&
                         written.st_uid == named.st_uid;
  if (same_user) shm_unlink(("/" + file->segment).c_str());
}

std::vector<std::string> files_of_others(const std::vector<std::string>& files) {
  std::vector<std::string> others;
  struct stat there {};
  std::ranges::copy_if(files, std::back_inserter(others), [&there](const std::string& file) {
    return geteuid() != 0 && lstat(file.c_str(), &there) == 0 && there.st_uid != geteuid();
  });
  return others;
}

std::vector<std::string> remove_daemon_files(const std::string& segment_name) {
  remove_status_file();
  std::vector<std::string> remaining;
  for (const std::string& file : daemon_files(segment_name)) {
    const bool is_lock = file == daemon_lock_path || file == host_file_path;
    if (!is_lock && !remove(file)) remaining.push_back(file);
  }
  return remaining;
}

std::string in_the_way(const std::vector<std::string>& files) {
  std::string list;
  std::string names;
  for (const std::string& file : files) {
    struct stat there {};
    const bool exists = lstat(file.c_str(), &there) == 0;
    list +=
        (list.empty() ? "" : ", ") + file + (exists ? " (of " + core::account_name(there.st_uid) + ")" : "");
    names += " " + file;
  }
  return "these files are in the way, and this account may not remove them: " + list +
         "; an sftd that was killed or an iox-roudi has left them, or another user wants to keep sftd from "
         "starting; "
         "remove them as root: rm -r" +
         names;
}

}  // namespace sft::shm
