// What can keep sftd from starting, as far as a program sees it without an attempt: files under the names
// that sftd needs, and too little space in /dev/shm. A look costs a few system calls, an attempt costs a
// process: so attempts are made ever more seldom, until a look shows that an obstacle is gone.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>
#include <vector>

namespace sft::shm {

/// The paths of a daemon's locks, its segments and its socket. Their names are fixed, most of them by
/// iceoryx. The segment of the samples has the name of the group of the writers.
std::vector<std::string> daemon_files(const std::string& segment_name);

/// The same for an sftd that this process starts without a configuration: its segment has the name of this
/// process's group. The name is looked up in the host's table of groups.
std::vector<std::string> files_of_own_daemon();

struct LaunchObstacles {
  /// A file that an sftd of this account does not simply replace. It is another one when it was replaced.
  struct File {
    std::string path{};
    dev_t device = 0;
    ino_t number = 0;
    uid_t owner = 0;
    mode_t type = 0;
    friend bool operator==(const File&, const File&) = default;
  };
  std::vector<File> files{};
  std::uint64_t free_bytes = 0;  ///< of the directory

  /// Those under these names, and the free space of this directory. An ordinary file or a socket of this
  /// account is no obstacle: sftd replaces it, and every attempt makes and removes such files.
  static LaunchObstacles look(const std::vector<std::string>& names, const char* directory = "/dev/shm");

  /// Adds the files that were found later. The free space stays: an attempt that fails takes some of it for a
  /// moment.
  void add_files_of(const LaunchObstacles& later);

  /// Whether something that was in the way `before` is not any more: a file is gone or is another one, or
  /// there is considerably more space. New obstacles do not count, because an attempt could only fail.
  bool have_eased_since(const LaunchObstacles& before) const;
};

}  // namespace sft::shm
