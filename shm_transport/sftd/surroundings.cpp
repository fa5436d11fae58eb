#include "shm_transport/sftd/surroundings.h"

#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

namespace sft::shm {

namespace {

/// `mount` is a command option for the user, in a shell and with docker.
std::string trouble_with(const std::string& directory, const std::string& mount) {
  struct stat there {};
  if (stat(directory.c_str(), &there) != 0 || !S_ISDIR(there.st_mode))
    return directory + " is not there: mount a tmpfs there (" + mount + ")";
  struct statvfs system {};
  if (statvfs(directory.c_str(), &system) == 0 && (system.f_flag & ST_RDONLY) != 0)
    return directory + " is read-only: mount a tmpfs there (" + mount + ")";
  if (access(directory.c_str(), W_OK | X_OK) != 0)
    return "this account may not write to " + directory + ": chmod 1777 " + directory;
  return "";
}

}  // namespace

std::string Surroundings::lacking() const {
  if (access((proc + "/self/stat").c_str(), R_OK) != 0)
    return proc + " is not mounted: mount it (mount -t proc proc " + proc +
           "), or start sftd where it is mounted";
  std::string trouble =
      trouble_with(shm, "mount -t tmpfs -o size=512m tmpfs " + shm + "; docker: --shm-size=512m");
  if (trouble.empty())
    trouble = trouble_with(tmp, "mount -t tmpfs tmpfs " + tmp + "; docker: --tmpfs " + tmp);
  return trouble;
}

}  // namespace sft::shm
