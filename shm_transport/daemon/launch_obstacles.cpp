#include "shm_transport/daemon/launch_obstacles.h"

#include <grp.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>

#include "shm_transport/host/host_file.h"
#include "shm_transport/host/iceoryx.h"

namespace sft::shm {

namespace {

/// The growth of free space that is a reason for a new attempt to start sftd: at least `bytes` or `files`,
/// and at least 1/`divisor` of the former free space. A smaller growth means nothing, because other
/// programs take and release space all the time.
struct LeastGrowth {
  std::uint64_t bytes;
  std::uint64_t files = 16;
  static constexpr std::uint64_t divisor = 8;
};
constexpr LeastGrowth in_shm{.bytes = std::uint64_t{16} << 20};
constexpr LeastGrowth in_tmp{.bytes = std::uint64_t{1} << 20};

bool has_grown(std::uint64_t before, std::uint64_t now, std::uint64_t least) {
  return now >= before + std::max(least, before / LeastGrowth::divisor);
}

bool has_grown(const LaunchObstacles::Space& before, const LaunchObstacles::Space& now,
               const LeastGrowth& least) {
  return has_grown(before.bytes, now.bytes, least.bytes) || has_grown(before.files, now.files, least.files);
}

LaunchObstacles::Space space_in(const char* directory) {
  struct statvfs space {};
  if (statvfs(directory, &space) != 0) return {};
  return {.bytes = std::uint64_t{space.f_bavail} * space.f_frsize, .files = space.f_favail};
}

std::string own_group_name() {
  group entry{};
  group* found = nullptr;
  std::array<char, 4096> text;
  if (getgrgid_r(getegid(), &entry, text.data(), text.size(), &found) != 0 || found == nullptr) return {};
  return found->gr_name;
}

bool contain(const std::vector<LaunchObstacles::File>& files, const LaunchObstacles::File& file) {
  return std::ranges::find(files, file) != files.end();
}

}  // namespace

std::vector<std::string> daemon_files(const std::string& segment_name) {
  const std::string roudi = roudi_socket_path;
  return {daemon_lock_path,
          host_file_path,
          roudi,
          roudi + ".lock",
          "/tmp/" + std::string(iox::roudi::ROUDI_LOCK_NAME) + ".lock",
          std::string("/dev/shm/") + iox::roudi::SHM_NAME,
          "/dev/shm/" + segment_name};
}

std::vector<std::string> files_of_own_daemon() {
  const std::string group = own_group_name();
  std::vector<std::string> files = daemon_files(group);
  if (group.empty()) files.pop_back();
  return files;
}

LaunchObstacles LaunchObstacles::look(const std::vector<std::string>& names, const char* shm,
                                      const char* tmp) {
  LaunchObstacles found{.shm = space_in(shm), .tmp = space_in(tmp)};
  for (const std::string& name : names) {
    struct stat there {};
    if (lstat(name.c_str(), &there) != 0) continue;
    const bool is_replaceable =
        there.st_uid == geteuid() && (S_ISREG(there.st_mode) || S_ISSOCK(there.st_mode));
    if (is_replaceable) continue;
    found.files.push_back({name, there.st_dev, there.st_ino, there.st_uid, there.st_mode & S_IFMT});
  }
  return found;
}

void LaunchObstacles::add(const LaunchObstacles& later) {
  std::ranges::copy_if(later.files, std::back_inserter(files),
                       [this](const File& file) { return !contain(files, file); });
  tmp = {.bytes = std::min(tmp.bytes, later.tmp.bytes), .files = std::min(tmp.files, later.tmp.files)};
}

bool LaunchObstacles::have_eased_since(const LaunchObstacles& before) const {
  return has_grown(before.shm, shm, in_shm) || has_grown(before.tmp, tmp, in_tmp) ||
         std::ranges::any_of(before.files, [this](const File& file) { return !contain(files, file); });
}

}  // namespace sft::shm
