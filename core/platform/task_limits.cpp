#include "core/platform/task_limits.h"

#include <algorithm>
#include <fstream>
#include <limits>
#include <sstream>
#include <string>

namespace sft::core {

namespace {

namespace fs = std::filesystem;

constexpr std::uint64_t unlimited = std::numeric_limits<std::uint64_t>::max();

/// Returns the number in a file. The word "max" means no limit.
std::optional<std::uint64_t> number_in(const fs::path& file) {
  std::ifstream stream(file);
  std::string word;
  if (!(stream >> word)) return {};
  if (word == "max") return unlimited;
  std::uint64_t number = 0;
  if (!(std::istringstream(word) >> number)) return {};
  return number;
}

/// Returns the total number of threads, from field 4 of /proc/loadavg, "running/total".
std::optional<std::uint64_t> threads_of_the_system(const fs::path& root) {
  std::ifstream stream(root / "proc/loadavg");
  std::string load, running;
  std::uint64_t all = 0;
  if (!(stream >> load >> load >> load) || !std::getline(stream, running, '/') || !(stream >> all)) return {};
  return all;
}

struct ControlGroup {
  fs::path mounted_at;
  fs::path path;  ///< the path of the group, relative to the mount point
};

/// Returns the control group that limits threads: the group of the controller `pids`, or, if there is none,
/// the group of the unified hierarchy.
std::optional<ControlGroup> control_group(const fs::path& root) {
  std::ifstream stream(root / "proc/self/cgroup");
  std::optional<ControlGroup> unified;
  for (std::string line; std::getline(stream, line);) {
    const std::size_t first = line.find(':'), second = line.find(':', first + 1);
    if (second == std::string::npos) return {};
    const std::string controllers = line.substr(first + 1, second - first - 1);
    const fs::path path = fs::path(line.substr(second + 1)).relative_path();
    if (controllers == "pids") return ControlGroup{root / "sys/fs/cgroup/pids", path};
    if (controllers.empty()) unified = ControlGroup{root / "sys/fs/cgroup", path};
  }
  return unified;
}

/// Returns the number of threads that can still be started within the limits of the group and of all its
/// ancestors.
std::optional<std::uint64_t> left_by_control_groups(const fs::path& root) {
  const std::optional<ControlGroup> group = control_group(root);
  std::error_code missing;
  if (!group || !fs::is_directory(group->mounted_at / group->path, missing)) return {};
  std::uint64_t left = unlimited;
  for (fs::path path = group->path;; path = path.parent_path()) {
    const fs::path directory = group->mounted_at / path;
    // A group without this file has no limit.
    const std::uint64_t limit = number_in(directory / "pids.max").value_or(unlimited);
    if (limit != unlimited) {
      const auto current = number_in(directory / "pids.current");
      if (!current) return {};
      left = std::min(left, limit - std::min(limit, *current));
    }
    if (path.empty()) return left;
  }
}

}  // namespace

std::optional<std::uint64_t> threads_left(rlim_t of_user, const fs::path& root) {
  const auto there = threads_of_the_system(root);
  const auto of_system = number_in(root / "proc/sys/kernel/threads-max");
  const auto ids = number_in(root / "proc/sys/kernel/pid_max");
  const auto of_groups = left_by_control_groups(root);
  if (!there || !of_system || !ids || !of_groups) return {};
  const std::uint64_t limit =
      std::min({*of_system, *ids, of_user == RLIM_INFINITY ? unlimited : std::uint64_t{of_user}});
  return std::min(*of_groups, limit - std::min(limit, *there));
}

}  // namespace sft::core
