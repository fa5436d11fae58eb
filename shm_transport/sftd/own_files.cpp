#include "shm_transport/sftd/own_files.h"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <tuple>

#include "shm_transport/host/iceoryx.h"
#include "shm_transport/sftd/stale_files.h"

namespace sft::shm {

namespace {

/// Returns the device of /dev/shm; 0 if it is not known.
dev_t device_of_shared_memory() {
  struct stat status {};
  return stat("/dev/shm", &status) == 0 ? status.st_dev : 0;
}

}  // namespace

void OwnFiles::note_segments() {
  shm_device_ = device_of_shared_memory();
  for (const std::string& name : {std::string(iox::roudi::SHM_NAME), segment_}) {
    const std::string path = "/dev/shm/" + name;
    struct stat made {};
    if (lstat(path.c_str(), &made) == 0) noted_.emplace_back(path, made.st_ino);
  }
}

bool OwnFiles::announce(const HostFile& file) {
  const std::string text = format(file);
  const DaemonLock lock{.pid = getpid(), .shm_device = device_of_shared_memory(), .user = geteuid()};
  return pwrite(host_file_.descriptor(), text.data(), text.size(), 0) == static_cast<ssize_t>(text.size()) &&
         dprintf(daemon_lock_.descriptor(), "%s", format_lock(lock).c_str()) > 0;
}

bool OwnFiles::are_removed() const {
  if (device_of_shared_memory() != shm_device_) return false;
  return !daemon_lock_.is_named() || !host_file_.is_named() ||
         std::ranges::any_of(noted_, [](const auto& segment) {
           struct stat named {};
           return lstat(segment.first.c_str(), &named) != 0 || named.st_ino != segment.second;
         });
}

void OwnFiles::remove_all(bool keep_lock) {
  struct stat other {};
  const bool names_are_ours =
      daemon_lock_.is_named() && (host_file_.is_named() || lstat(host_file_path, &other) != 0);
  std::ignore = ftruncate(daemon_lock_.descriptor(), 0);  // the contents of the lock file are no longer true
  host_file_.remove();
  if (names_are_ours) remove_daemon_files(segment_);
  if (!keep_lock) daemon_lock_.remove();
}

}  // namespace sft::shm
