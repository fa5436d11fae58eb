#include "shm_transport/sftd/running_daemon.h"

#include <pwd.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <system_error>

namespace sft::shm {

namespace {

namespace fs = std::filesystem;

std::string text_of(const fs::path& file) {
  std::ifstream stream(file);
  return {std::istreambuf_iterator<char>(stream), {}};
}

bool is_host_file(const fs::path& open_file) {
  struct stat opened {};
  struct stat named {};
  return stat(open_file.c_str(), &opened) == 0 && stat(host_file_path, &named) == 0 &&
         opened.st_dev == named.st_dev && opened.st_ino == named.st_ino;
}

/// Programs have the file open, too; only the daemon has a lock on it.
bool holds_host_file(pid_t pid) {
  const fs::path process = "/proc/" + std::to_string(pid);
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(process / "fd", error)) {
    if (is_host_file(entry.path()) &&
        text_of(process / "fdinfo" / entry.path().filename()).find("OFDLCK") != std::string::npos)
      return true;
  }
  return false;
}

std::string name_of(uid_t user) {
  const passwd* entry = getpwuid(user);
  return entry != nullptr ? entry->pw_name : std::to_string(user);
}

}  // namespace

tl::expected<RunningDaemon, RunningDaemon::Absence> RunningDaemon::find() {
  auto found = HostWatch::look();
  struct stat written {};
  if (found.watch && stat(host_file_path, &written) == 0)
    return RunningDaemon(std::move(*found.watch), written.st_uid);
  if (found.finding == HostWatch::Finding::starting)
    return tl::unexpected(
        Absence{ExitCode::no_answer, "the daemon is starting, or was stopped while it did"});
  if (is_locked_at(daemon_lock_path))
    return tl::unexpected(
        Absence{ExitCode::not_running, "the daemon is starting or ending, or has another /dev/shm"});
  return tl::unexpected(Absence{ExitCode::not_running, "no daemon is running"});
}

Result<Descriptor> RunningDaemon::process() const {
  const uid_t self = geteuid();
  if (self != user_ && self != 0) {
    return fail(Errc::no_permission, "the daemon (pid " + std::to_string(pid()) + ") is of user " +
                                         name_of(user_) + "; run this as that user, or as root");
  }
  Descriptor process(static_cast<int>(syscall(SYS_pidfd_open, pid(), 0)));
  if (!process || !holds_host_file(pid())) {
    return fail(Errc::unavailable, "the daemon runs in another container (pid " + std::to_string(pid()) +
                                       " there), and cannot be reached from here; run this there");
  }
  return process;
}

bool RunningDaemon::is_stopped() const {
  const std::string stat = text_of("/proc/" + std::to_string(pid()) + "/stat");
  const auto behind_name = stat.rfind(") ");
  if (behind_name == std::string::npos || behind_name + 2 >= stat.size()) return false;
  const char state = stat[behind_name + 2];
  return (state == 'T' || state == 't') && holds_host_file(pid());
}

}  // namespace sft::shm
