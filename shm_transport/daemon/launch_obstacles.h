// Looks for what can keep sftd from starting: files with the names that sftd needs, and too little space in
// /dev/shm. Such a look costs a few system calls, while an attempt to start sftd costs a process. So attempts
// are made ever more seldom, until a look shows that an obstacle is gone.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>
#include <vector>

namespace sft::shm {

/// Returns the paths of a daemon's locks, segments and socket. These names are fixed, most of them by
/// iceoryx. The segment of the samples has the name of the group of the writers.
std::vector<std::string> daemon_files(const std::string& segment_name);

/// Returns the same paths for an sftd that this process starts without a configuration. The segment of that
/// sftd has the name of this process's group, which is looked up in the host's table of groups.
std::vector<std::string> files_of_own_daemon();

struct LaunchObstacles {
  /// A file that an sftd of this account does not simply replace. A file that has replaced it compares
  /// unequal.
  struct File {
    std::string path{};
    dev_t device = 0;
    ino_t number = 0;
    uid_t owner = 0;
    mode_t type = 0;
    friend bool operator==(const File&, const File&) = default;
  };
  std::vector<File> files{};
  std::uint64_t free_bytes = 0;  ///< free space in the directory

  /// Looks for files with these names, and at the free space of the directory. An ordinary file or a socket
  /// of this account is no obstacle, because sftd replaces it, and because each attempt makes and removes
  /// such files.
  static LaunchObstacles look(const std::vector<std::string>& names, const char* directory = "/dev/shm");

  /// Adds the files that were found later. The free space stays as it is, because an attempt that fails takes
  /// some space for a moment.
  void add_files_of(const LaunchObstacles& later);

  /// Returns whether something that was in the way `before` is not in the way any more: a file is gone or was
  /// replaced, or there is considerably more space. New obstacles do not count, because with them an attempt
  /// could only fail.
  bool have_eased_since(const LaunchObstacles& before) const;
};

}  // namespace sft::shm
