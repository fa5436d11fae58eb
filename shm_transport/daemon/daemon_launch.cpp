#include "shm_transport/daemon/daemon_launch.h"

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <string>

#include "core/platform/thread.h"

extern char** environ;

namespace sft::shm {

namespace {

/// The settings of the new process: it has only its three standard descriptors, and no signal is blocked or
/// ignored.
class SpawnSettings {
 public:
  explicit SpawnSettings(int standard_error) {
    posix_spawn_file_actions_init(&actions_);
    posix_spawn_file_actions_addopen(&actions_, 0, "/dev/null", O_RDONLY, 0);
    posix_spawn_file_actions_addopen(&actions_, 1, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_adddup2(&actions_, standard_error, 2);
    posix_spawn_file_actions_addclosefrom_np(&actions_, 3);
    posix_spawnattr_init(&attributes_);
    sigset_t signals;
    sigemptyset(&signals);
    posix_spawnattr_setsigmask(&attributes_, &signals);
    sigfillset(&signals);
    posix_spawnattr_setsigdefault(&attributes_, &signals);
    posix_spawnattr_setflags(&attributes_,
                             POSIX_SPAWN_SETSID | POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF);
  }
  ~SpawnSettings() {
    posix_spawn_file_actions_destroy(&actions_);
    posix_spawnattr_destroy(&attributes_);
  }
  SpawnSettings(const SpawnSettings&) = delete;
  SpawnSettings& operator=(const SpawnSettings&) = delete;

  const posix_spawn_file_actions_t* actions() const { return &actions_; }
  const posix_spawnattr_t* attributes() const { return &attributes_; }

 private:
  posix_spawn_file_actions_t actions_;
  posix_spawnattr_t attributes_;
};

Errc errc_of(int error) { return error == ENOENT ? Errc::unavailable : Errc::system; }

}  // namespace

Result<DaemonLaunch> DaemonLaunch::begin(const ShmOptions& options, const DaemonPlaces& places) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0) return fail(Errc::system, std::string("pipe: ") + std::strerror(errno));
  Descriptor read_end(ends[0]);
  const Descriptor write_end(ends[1]);
  fcntl(read_end.get(), F_SETFL, O_NONBLOCK);

  const bool is_named = !options.daemon_path.empty();
  const FoundDaemon found = is_named ? FoundDaemon{options.daemon_path} : find_daemon(places);
  const std::string& path = found.path;
  std::string idle_exit = "--idle-exit=" + std::to_string(options.daemon_idle_exit.count());
  std::array<char*, 3> arguments{const_cast<char*>(path.c_str()), idle_exit.data(), nullptr};
  const SpawnSettings settings(write_end.get());
  pid_t child = -1;
  int error = 0;
  const auto spawn = [&] {
    error = posix_spawnp(&child, path.c_str(), settings.actions(), settings.attributes(), arguments.data(),
                         environ);
  };
  // A daemon inherits the CPUs and the scheduling policy of the thread that starts it. These settings must
  // not be those of this program's thread, because the daemon also serves other programs. So a separate
  // thread with the usual settings starts the daemon.
  Result<std::thread> spawning = core::start_thread("sft-launch", spawn);
  if (!spawning) return tl::unexpected(spawning.error());
  spawning->join();
  if (error != 0) {
    const std::string reason = path + " could not be started: " + std::strerror(error);
    if (is_named) return fail(errc_of(error), reason + "; " + options.daemon_named_by + " names it");
    if (error != ENOENT || path.find('/') != std::string::npos) return fail(errc_of(error), reason);
    return fail(Errc::unavailable, path + " could not be started: " + explain_missing_daemon(found));
  }
  return DaemonLaunch(child, std::move(read_end));
}

DaemonLaunch::~DaemonLaunch() {
  if (child_is_gone()) return;
  kill(child_, SIGKILL);
  while (waitpid(child_, nullptr, 0) < 0 && errno == EINTR) continue;
}

bool DaemonLaunch::child_is_gone() noexcept {
  // waitpid() returns -1 if the program itself has already reaped the child.
  if (child_ > 0 && waitpid(child_, nullptr, WNOHANG) != 0) child_ = 0;
  return child_ == 0;
}

std::optional<DaemonLaunch::Outcome> DaemonLaunch::poll() {
  char text[512];
  ssize_t bytes = 0;
  while ((bytes = read(error_output_.get(), text, sizeof text)) > 0)
    error_text_.append(text, static_cast<std::size_t>(bytes));
  if (bytes < 0 || !child_is_gone()) return std::nullopt;  // the child still runs, or is about to exit
  while (!error_text_.empty() && error_text_.back() == '\n') error_text_.pop_back();
  return Outcome{error_text_};
}

}  // namespace sft::shm
