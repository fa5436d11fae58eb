#include "shm_transport/sftd/running_daemon.h"

#include <pwd.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <filesystem>
#include <system_error>

#include "core/platform/text_of.h"

namespace sft::shm {

namespace {

namespace fs = std::filesystem;

bool is_file(const fs::path& open_file, const char* path) {
  struct stat opened {};
  struct stat named {};
  return stat(open_file.c_str(), &opened) == 0 && lstat(path, &named) == 0 && opened.st_dev == named.st_dev &&
         opened.st_ino == named.st_ino;
}

/// Returns whether the process has a lock on this file. Programs have the file open as well, but only the
/// daemon has a lock on it.
bool has_locked(pid_t pid, const char* path) {
  const fs::path process = "/proc/" + std::to_string(pid);
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(process / "fd", error)) {
    if (is_file(entry.path(), path) &&
        core::text_of(process / "fdinfo" / entry.path().filename()).find("OFDLCK") != std::string::npos)
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
  auto found = HostMonitor::look({.everybody = true});
  if (found.monitor) return RunningDaemon(found.monitor->file().pid, found.monitor->user(), host_file_path);
  if (found.finding == HostMonitor::Finding::starting)
    return tl::unexpected(
        Absence{ExitCode::no_answer, "the daemon is starting, or was stopped while it started"});
  const auto lock = read_daemon_lock();
  if (lock && lock->serves_this_shm())
    return RunningDaemon(lock->pid, lock->user, daemon_lock_path, names_are_gone(lock->pid));
  if (lock)
    return tl::unexpected(
        Absence{ExitCode::not_running, "the daemon is starting or ending, or has another /dev/shm"});
  return tl::unexpected(Absence{ExitCode::not_running, "no daemon is running"});
}

Result<Descriptor> RunningDaemon::process() const {
  const uid_t self = geteuid();
  if (self != user() && self != 0) {
    return fail(Errc::no_permission, "the daemon (pid " + std::to_string(pid()) + ") is of user " +
                                         name_of(user()) + "; run this command as that user, or as root");
  }
  Descriptor process(static_cast<int>(syscall(SYS_pidfd_open, pid(), 0)));
  if (!process || !has_locked(pid(), lock_)) {
    return fail(Errc::unavailable, "the daemon runs in another container (pid " + std::to_string(pid()) +
                                       " there), and cannot be reached from here; run this command there");
  }
  return process;
}

bool RunningDaemon::is_stopped() const {
  const std::string stat = core::text_of("/proc/" + std::to_string(pid()) + "/stat");
  const auto behind_name = stat.rfind(") ");
  if (behind_name == std::string::npos || behind_name + 2 >= stat.size()) return false;
  const char state = stat[behind_name + 2];
  return (state == 'T' || state == 't') && has_locked(pid(), lock_);
}

}  // namespace sft::shm
