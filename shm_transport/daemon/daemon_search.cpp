#include "shm_transport/daemon/daemon_search.h"

#include <dlfcn.h>
#include <link.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>

#include "core/platform/trusted_file.h"

namespace sft::shm {

namespace {

namespace fs = std::filesystem;

/// Returns the directory from which the program was started, even if its file was removed or replaced since
/// then.
fs::path directory_of_program() {
  std::error_code error;
  return fs::read_symlink("/proc/self/exe", error).parent_path();
}

/// Returns the directory of the shared library that has this function. Empty in two cases: the function is
/// linked into the program itself, or the loader knows the library only by a path relative to the directory
/// that was current when it was loaded.
fs::path directory_of_library() {
  Dl_info symbol{};
  void* extra = nullptr;
  if (dladdr1(reinterpret_cast<void*>(&directory_of_library), &symbol, &extra, RTLD_DL_LINKMAP) == 0)
    return {};
  const fs::path name = static_cast<const link_map*>(extra)->l_name;
  std::error_code error;
  return name.is_absolute() ? fs::canonical(name, error).parent_path() : fs::path();
}

bool is_program(const std::string& path) {
  struct stat file {};
  return stat(path.c_str(), &file) == 0 && S_ISREG(file.st_mode) && access(path.c_str(), X_OK) == 0;
}

void add_place(std::vector<std::string>& places, const fs::path& directory, const char* file) {
  if (directory.empty()) return;
  std::string place = (directory / file).lexically_normal();
  if (std::ranges::find(places, place) == places.end()) places.push_back(std::move(place));
}

}  // namespace

DaemonPlaces DaemonPlaces::of_this_process() {
  DaemonPlaces places;
  const fs::path here = directory_of_program();
  add_place(places.beside, here, "sftd");
  add_place(places.beside, here, "../libexec/sft/sftd");
  add_place(places.beside, directory_of_library(), SFT_DAEMON_FROM_LIBRARY);
  places.built_in.emplace_back(SFT_DAEMON_INSTALLED);
#ifdef SFT_DAEMON_BUILT
  places.built_in.emplace_back(SFT_DAEMON_BUILT);
#endif
  return places;
}

FoundDaemon find_daemon(const DaemonPlaces& places) {
  FoundDaemon found;
  for (const std::string& place : places.beside) {
    if (is_program(place)) return {place};
    found.missed.push_back(place);
  }
  for (const std::string& place : places.built_in) {
    if (std::ranges::find(found.missed, place) != found.missed.end()) continue;
    // Links are resolved first, because a link on the way to the file may belong to another account.
    std::error_code error;
    const std::string file = fs::canonical(place, error);
    const bool is_there = !error && is_program(file);
    if (is_there && is_under_own_control(file)) return {file};
    found.missed.push_back(is_there ? place + " (which other accounts than root and this one can replace)"
                                    : place);
  }
  return found;
}

std::string explain_missing_daemon(const FoundDaemon& found) {
  std::string text = "it is neither ";
  for (const std::string& place : found.missed) text += place + " nor ";
  return text +
         "in PATH; install SFT, or name the file of sftd in the environment variable SFT_DAEMON or in "
         "NodeOptions::shm.daemon_path";
}

bool is_under_own_control(const std::string& file) {
  const core::TrustedAccounts own;
  fs::path part = file;
  while (true) {
    struct stat there {};
    if (lstat(part.c_str(), &there) != 0 || !own.include_user(there.st_uid)) return false;
    // In a sticky directory other accounts can make files, but cannot replace this file.
    const bool is_shared = S_ISDIR(there.st_mode) && (there.st_mode & S_ISVTX) != 0;
    if ((there.st_mode & S_IWOTH) != 0 && !is_shared) return false;
    if (part == part.root_path()) return true;
    part = part.parent_path();
  }
}

}  // namespace sft::shm
