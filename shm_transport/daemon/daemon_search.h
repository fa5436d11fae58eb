// Finds the file of sftd for a program that starts it, or explains where it was not found.
#pragma once

#include <sys/types.h>

#include <string>
#include <vector>

namespace sft::shm {

/// The paths that are tried for the file of sftd, in this order. PATH comes last.
struct DaemonPlaces {
  /// Paths relative to the program, and to the shared library that has this code. An account that can write
  /// to these paths could also change the program or the library, so these paths need no check.
  std::vector<std::string> beside{};
  /// Paths that were fixed when SFT was built. By now another account may own such a path. So a file at the
  /// path is used only if no account except root and this one could have put it there.
  std::vector<std::string> built_in{};

  static DaemonPlaces of_this_process();
};

struct FoundDaemon {
  /// The path of the file, or the bare name if no place has the file. If it is the bare name, PATH is
  /// searched for it.
  std::string path = "sftd";
  /// The places where no usable file was found. If a place has a file that must not be used, the reason
  /// follows its path.
  std::vector<std::string> missed{};
};
FoundDaemon find_daemon(const DaemonPlaces& places);

/// Returns "it is neither A nor B nor in PATH; ...", a text that says why the bare name could not be
/// started, and what to do.
std::string explain_missing_daemon(const FoundDaemon& found);

/// Returns whether only root and this account can replace the file at this path, or change its contents.
/// The path must contain no symbolic link. Rights of groups are not considered, because on many systems
/// each account has a group of its own that may write.
bool is_under_own_control(const std::string& file);

}  // namespace sft::shm
