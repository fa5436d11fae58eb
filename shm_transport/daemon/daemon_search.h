// Where a program that starts sftd looks for its file, and what is said where it is in none of these places.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace sft::shm {

/// In this order, and last in PATH.
struct DaemonPlaces {
  /// Relative to the program, and to the shared library that this code is a part of. Whoever could write
  /// there could as well have changed these.
  std::vector<std::string> beside{};
  /// Paths that are known since SFT was built. By now somebody else may have got one of them, so a file
  /// counts only if root or this account alone could have put it there.
  std::vector<std::string> built_in{};

  static DaemonPlaces of_this_process();
};

struct FoundDaemon {
  /// The bare name, for which PATH is searched, if it is in none of the places.
  std::string path = "sftd";
  /// The places that were tried in vain. One that has a file is there with the reason.
  std::vector<std::string> missed{};
};
FoundDaemon find_daemon(const DaemonPlaces& places);

/// "it is neither A nor B nor in PATH; ...": why a bare name could not be started, and what to do.
std::string explain_missing_daemon(const FoundDaemon& found);

/// Whether only root and this account can change which file has that path, without links, and what is in it.
/// Groups are not considered, since many systems give each account one of its own, and let it write.
bool is_under_own_control(const std::string& file);

}  // namespace sft::shm
