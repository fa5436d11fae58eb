// Looks for obstacles that can keep sftd from starting: files with the names that sftd needs, and too
// little space in /dev/shm or /tmp. A search for obstacles costs a few system calls, while an attempt to
// start sftd costs a process. So attempts become ever rarer, until a search finds that an obstacle is gone.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <string>
#include <vector>

namespace sft::shm {

/// Returns the paths of a daemon's locks, segments and socket. These names are fixed, most of them by
/// iceoryx. The segment of the samples has the name of the group of the writers.
std::vector<std::string> daemon_files(const std::string& segment_name);

/// Returns the paths for an sftd that this process starts without a configuration. The segment of that sftd
/// has the name of this process's group, which is looked up in the host's table of groups.
std::vector<std::string> files_of_own_daemon();

struct LaunchObstacles {
  /// A file that an sftd of this account cannot simply replace. A different file that was put at the same
  /// path later compares unequal.
  struct File {
    std::string path{};
    dev_t device = 0;
    ino_t number = 0;
    uid_t owner = 0;
    mode_t type = 0;
    friend bool operator==(const File&, const File&) = default;
  };
  /// The free space in a directory; 0 if it is not known.
  struct Space {
    std::uint64_t bytes = 0;
    std::uint64_t files = 0;  ///< number of files that can still be created
    friend bool operator==(const Space&, const Space&) = default;
  };
  std::vector<File> files{};
  Space shm{};  ///< space in the directory of the segments
  Space tmp{};  ///< space in the directory of locks and sockets

  /// Looks for files with these names, and determines the free space in the directories. An ordinary file
  /// or a socket of this account is no obstacle, because sftd replaces it, and because each attempt makes
  /// and removes such files.
  static LaunchObstacles look(const std::vector<std::string>& names, const char* shm = "/dev/shm",
                              const char* tmp = "/tmp");

  /// Adds obstacles that were found after the attempt had failed: further files, and less space in /tmp.
  /// Does not update the space in /dev/shm, because a failing attempt takes much of that space for a short
  /// time.
  void add(const LaunchObstacles& later);

  /// Returns whether an obstacle in `before` is gone: a file was removed or replaced, or there is
  /// considerably more space. New obstacles do not count, because with them an attempt could only fail.
  bool have_eased_since(const LaunchObstacles& before) const;
};

}  // namespace sft::shm
