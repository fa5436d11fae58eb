// The files by which programs find a daemon and its memory: the lock in /tmp, the host file in /dev/shm,
// and the segments. Another process may remove these files while the daemon runs. In that case no program
// can join the daemon any more.
#pragma once

#include <sys/types.h>

#include <string>
#include <utility>
#include <vector>

#include "shm_transport/host/file_lock.h"
#include "shm_transport/host/host_file.h"

namespace sft::shm {

class OwnFiles {
 public:
  /// `segment` is the name of the segment of samples.
  OwnFiles(FileLock daemon_lock, FileLock host_file, std::string segment)
      : daemon_lock_(std::move(daemon_lock)),
        host_file_(std::move(host_file)),
        segment_(std::move(segment)) {}

  /// Notes the segments after they were made, to find out later whether they were removed.
  void note_segments();
  /// Writes the host file, and writes into the lock file which daemon this is. Returns false if there is no
  /// space.
  bool announce(const HostFile& file);

  /// Returns whether any of the files was removed. If another file system was mounted over /dev/shm, the
  /// files were not removed. In that case new programs report that they have another /dev/shm than this
  /// daemon, and the daemon continues to serve the old programs.
  bool are_removed() const;

  /// Removes all files of this daemon. If the files were removed while this daemon ran, files with these
  /// names can belong to another daemon by now; such files stay. If `keep_lock` is true, the lock in /tmp
  /// stays, because programs do not start another daemon while this lock exists.
  void remove_all(bool keep_lock);
  /// Releases the lock of the host file, so that programs notice that the daemon is gone.
  void unlock_host_file() { host_file_.unlock(); }

 private:
  FileLock daemon_lock_;  ///< the lock that keeps other daemons out of this /tmp
  FileLock host_file_;    ///< the lock that keeps other daemons out of this /dev/shm
  const std::string segment_;
  dev_t shm_device_ = 0;                              ///< the device of the file system with the segments
  std::vector<std::pair<std::string, ino_t>> noted_;  ///< the path and the inode of each segment
};

}  // namespace sft::shm
