#include "shm_transport/sftd/daemon.h"

#include <signal.h>
#include <sys/random.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <mutex>
#include <thread>
#include <tuple>

#include "core/platform/clock.h"
#include "core/platform/doorbell.h"
#include "core/platform/process_limits.h"
#include "shm_transport/daemon/accepted_daemons.h"
#include "shm_transport/daemon/launch_obstacles.h"
#include "shm_transport/host/access.h"
#include "shm_transport/host/host_file.h"
#include "shm_transport/host/iceoryx.h"
#include "shm_transport/sftd/stale_files.h"
#include "shm_transport/sftd/status_file.h"

namespace sft::shm {

namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr std::size_t MiB = 1 << 20;
constexpr std::size_t smallest_shm_bytes = 128 * MiB;
constexpr std::size_t default_pool_bytes = 320 * MiB;
constexpr auto tick = 500ms;
constexpr auto sweep_interval = 10s;
// How long the daemon waits without clients before it starts afresh. In this time a service manager can start
// a program again that has crashed.
constexpr auto renewal_delay = 2s;
// A daemon that is younger than this does not start afresh.
constexpr auto youngest_to_renew = 1s;
// Nodes look for their daemon each 50 ms, and release its memory when it is gone. This time is enough for
// that.
constexpr auto time_to_release = 200ms;

struct Space {
  std::size_t total = 0;
  std::size_t free = 0;
};

Space shm_space() {
  struct statvfs status {};
  if (statvfs("/dev/shm", &status) != 0) return {};
  return {status.f_blocks * status.f_frsize, status.f_bavail * status.f_frsize};
}

/// The memory for samples is a file to the system. The program that starts the daemon may have set a limit
/// for the size of its own files, which the daemon inherits.
void raise_file_size_limit() {
  rlimit limit{};
  if (getrlimit(RLIMIT_FSIZE, &limit) != 0) return;
  limit.rlim_cur = limit.rlim_max;
  std::ignore = setrlimit(RLIMIT_FSIZE, &limit);
}

tl::unexpected<StartFailure> refuse(ExitCode code, std::string message) {
  return tl::unexpected(StartFailure{code, std::move(message)});
}

tl::unexpected<StartFailure> refuse_for_space(const Space& space, std::size_t needed) {
  return refuse(ExitCode::no_space, "/dev/shm has " + format_bytes(space.total) + ", of which " +
                                        format_bytes(space.free) + " are free, and shared memory needs " +
                                        format_bytes(needed) +
                                        "; enlarge /dev/shm (docker run --shm-size=512m, or mount -o "
                                        "remount,size=512m /dev/shm); until then "
                                        "samples go over UDP");
}

tl::expected<PoolPlan, StartFailure> take_pools(const DaemonSettings& settings, const Groups& groups,
                                                const Space& space) {
  PoolPlan plan{settings.pools, {}};
  const std::size_t needed = HostMemory::management_bytes(make_config(plan, groups)) + plan.bytes();
  if (space.free < needed) return refuse_for_space(space, needed);
  return plan;
}

/// Chooses the pools. The memory for samples is as large as the settings say, or else half of the free space,
/// up to a default.
tl::expected<PoolPlan, StartFailure> choose_pools(const DaemonSettings& settings, const Groups& groups) {
  const Space space = shm_space();
  if (space.total < smallest_shm_bytes) return refuse_for_space(space, smallest_shm_bytes);
  if (!settings.pools.empty()) return take_pools(settings, groups, space);
  const std::size_t wanted = settings.pool_bytes.value_or(default_pool_bytes);
  const std::size_t management = HostMemory::management_bytes(make_config(plan_pools(wanted), groups));
  const std::size_t least = settings.pool_bytes.value_or(2 * smallest_budget_bytes);
  if (space.free < management + least) return refuse_for_space(space, management + least);
  const std::size_t half = (space.free - management) / 2;
  return plan_pools(settings.pool_bytes ? wanted : std::min(half, wanted));
}

ExitCode code_of(const Error& error) {
  return error.code == Errc::invalid_argument ? ExitCode::bad_config : ExitCode::failed;
}

/// Receives the errors that iceoryx reports. While the daemon starts, an error must end the process: iceoryx
/// would go on without the memory, files or sockets that it could not get, and crash. Later each error
/// concerns one client, which gets an answer.
struct ErrorSink {
  const Log* log = nullptr;
  std::mutex mutex;                                     // guards end_start
  std::function<void(const std::string&)> end_start{};  ///< ends the process; set while the daemon starts

  void report(const iox::Error error, const iox::ErrorLevel level) {
    const std::string text = std::string("iceoryx reports ") + iox::ErrorHandler::toString(error);
    const bool moderate = level == iox::ErrorLevel::MODERATE;
    log->write(moderate ? LogLevel::debug : LogLevel::warning, text);
    const std::scoped_lock lock(mutex);
    if (!moderate && end_start) end_start(text);
  }
  void begin(std::function<void(const std::string&)> end) {
    const std::scoped_lock lock(mutex);
    end_start = std::move(end);
  }
};

ErrorSink& error_sink() {
  static ErrorSink sink;
  return sink;
}

iox::cxx::GenericRAII log_errors(const Log& log) {
  error_sink().log = &log;
  static const iox::HandlerFunction handler = [](const iox::Error error, const std::function<void()>&,
                                                 const iox::ErrorLevel level) {
    error_sink().report(error, level);
  };
  return iox::ErrorHandler::setTemporaryErrorHandler(handler);
}

DaemonLock own_lock() {
  struct stat shm {};
  stat("/dev/shm", &shm);
  return {.pid = getpid(), .shm_device = shm.st_dev, .user = geteuid()};
}

template <class Condition>
bool wait_until(Clock::time_point deadline, Condition condition) {
  while (!condition()) {
    if (Clock::now() >= deadline) return false;
    std::this_thread::sleep_for(1ms);
  }
  return true;
}

/// Says which other daemon has the lock in /tmp. The host file of a daemon in /dev/shm comes a moment after
/// its lock, so this function waits for it. The programs of this account do not accept the daemon of another
/// user's account.
tl::unexpected<StartFailure> refuse_beside_another() {
  const auto other = read_daemon_lock();
  if (other && !accepted_daemons({}).include_user(other->user)) {
    return refuse(ExitCode::failed, "an sftd of " + core::account_name(other->user) + " (pid " +
                                        std::to_string(other->pid) + ") has locked " + daemon_lock_path +
                                        ", and there can be only one sftd; end it, as that user or as root: "
                                        "sftd stop, or kill " +
                                        std::to_string(other->pid));
  }
  const auto settled = [] {
    return HostWatch::look({.everybody = true}).finding != HostWatch::Finding::absent ||
           !is_locked_at(daemon_lock_path);
  };
  if (wait_until(Clock::now() + 1s, settled)) return refuse(ExitCode::done, "already running");
  return refuse(
      ExitCode::failed,
      "an sftd with another /dev/shm has the same /tmp; share both directories with its container, or "
      "neither");
}

/// Returns nothing if no daemon lives in this /tmp, as far as this account may ask.
std::optional<StartFailure> refuse_beside_the_living() {
  if (is_locked_at(daemon_lock_path)) return refuse_beside_another().value();
  if (socket_state_at(roudi_socket_path) != SocketState::alive) return std::nullopt;
  struct stat socket {};
  const bool named = lstat(roudi_socket_path, &socket) == 0;
  return StartFailure{
      ExitCode::foreign_daemon,
      "another iceoryx daemon (iox-roudi) is running" +
          (named ? ", of " + core::account_name(socket.st_uid) : "") +
          "; stop that daemon: sftd serves SFT's programs instead, and the two cannot share /tmp/roudi"};
}

tl::unexpected<StartFailure> refuse_host_file(const Error& error) {
  if (error.code != Errc::address_in_use) return refuse(ExitCode::failed, error.message);
  return refuse(ExitCode::failed,
                error.message +
                    "; an sftd with another /tmp has the same /dev/shm; share both directories with its "
                    "container, or neither");
}

}  // namespace

Daemon::Daemon(const DaemonSettings& settings, const Log& log, FileLock daemon_lock, FileLock host_file,
               Groups groups)
    : settings_(settings),
      log_(log),
      daemon_lock_(std::move(daemon_lock)),
      host_file_(std::move(host_file)),
      groups_(std::move(groups)),
      since_ns_(core::realtime_ns()),
      error_handler_(log_errors(log)) {}

/// The order matters: this daemon takes its locks before it touches anything of iceoryx, because iceoryx
/// aborts if it finds another daemon. Only locks and sockets tell whether a daemon lives. All other files are
/// leftovers.
Daemon::Started Daemon::start(const DaemonSettings& settings, const Log& log, EndProcess end) {
  raise_file_size_limit();
  if (const auto large_enough = core::check_file_size(smallest_shm_bytes); !large_enough)
    return refuse(ExitCode::no_space, large_enough.error().message);
  auto groups = take_up_groups(settings.access);
  if (!groups) return refuse(code_of(groups.error()), groups.error().message);
  if (auto living = refuse_beside_the_living()) return tl::unexpected(*living);
  if (const auto others = files_of_others(daemon_files(groups->writers)); !others.empty())
    return refuse(ExitCode::failed, in_the_way(others));
  auto daemon_lock = FileLock::take(daemon_lock_path);
  if (!daemon_lock) {
    if (daemon_lock.error().code == Errc::address_in_use) return refuse_beside_another();
    return refuse(ExitCode::failed, daemon_lock.error().message);
  }
  remove_segment_of_the_dead();
  auto host_file = FileLock::take(host_file_path);
  if (!host_file) return refuse_host_file(host_file.error());
  std::unique_ptr<Daemon> daemon(
      new Daemon(settings, log, std::move(*daemon_lock), std::move(*host_file), std::move(*groups)));
  if (const auto remaining = remove_daemon_files(daemon->groups_.writers); !remaining.empty())
    return refuse(ExitCode::failed, in_the_way(remaining));
  remove_dead_sockets();
  core::DoorbellPage::sweep();
  auto plan = choose_pools(settings, daemon->groups_);
  if (!plan) return tl::unexpected(plan.error());
  if (const auto large_enough = core::check_file_size(plan->bytes()); !large_enough)
    return refuse(ExitCode::no_space, large_enough.error().message);
  error_sink().begin([&daemon, &end](const std::string& text) {
    daemon->remove_files(false);
    end({ExitCode::failed, "sftd cannot start: " + text +
                               "; are /tmp and /dev/shm writable, and is there space left? sftd --foreground "
                               "--log-level=debug says more"});
  });
  auto failure = daemon->host(*plan);
  error_sink().begin({});
  if (failure) return tl::unexpected(*failure);
  return daemon;
}

std::optional<StartFailure> Daemon::host(const PoolPlan& plan) {
  auto lock = iox::posix::FileLock::create(iox::roudi::ROUDI_LOCK_NAME);
  if (lock.has_error()) {
    return StartFailure{ExitCode::foreign_daemon,
                        "another iceoryx daemon (iox-roudi) is starting; stop that daemon"};
  }
  roudi_lock_.emplace(std::move(lock.value()));
  auto memory = HostMemory::make(make_config(plan, groups_), groups_);
  if (!memory) return StartFailure{ExitCode::no_space, memory.error().message};
  memory_ = std::move(*memory);
  ports_ = std::make_unique<iox::roudi::PortManager>(memory_.get());
  roudi_ = std::make_unique<RoudiHost>(*memory_, *ports_, groups_, settings_.limits, log_);
  plan_ = plan;
  const auto serves = [] { return socket_state_at(roudi_socket_path) == SocketState::alive; };
  if (!wait_until(Clock::now() + 5s, serves))
    return StartFailure{ExitCode::failed, "iceoryx has made no socket at /tmp/roudi; is /tmp writable?"};
  if (const auto admitted = admit_readers(); !admitted)
    return StartFailure{ExitCode::failed, "the group " + groups_.readers +
                                              " cannot be given rights to read: " + admitted.error().message};
  note_segments();
  if (!announce())
    return StartFailure{ExitCode::failed, std::string(host_file_path) + " or " + daemon_lock_path +
                                              " could not be written; is there space left?"};
  log_.info(description());
  if (!plan.remark.empty()) log_.warning(plan.remark);
  return std::nullopt;
}

bool Daemon::announce() {
  write_status();
  HostFile file;
  file.pid = getpid();
  file.port_pool_offset = memory_->port_pool_offset();
  file.protocol = host_protocol;
  file.segment = groups_.writers;
  file.segment_id = memory_->samples().id;
  file.segment_bytes = memory_->samples().bytes;
  file.readers = groups_.reader_id;
  if (getrandom(file.token.data(), file.token.size(), 0) != static_cast<ssize_t>(file.token.size()))
    return false;
  const std::string text = format(file);
  return pwrite(host_file_.descriptor(), text.data(), text.size(), 0) == static_cast<ssize_t>(text.size()) &&
         dprintf(daemon_lock_.descriptor(), "%s", format_lock(own_lock()).c_str()) > 0;
}

/// Gives readers the rights to the management segment and to the socket that writers have. iceoryx itself has
/// made the segment of samples readable for them.
Result<void> Daemon::admit_readers() {
  if (!groups_.reader_id) return {};
  for (const std::string& path :
       {std::string("/dev/shm/") + iox::roudi::SHM_NAME, std::string(roudi_socket_path)}) {
    if (auto granted = grant_to_group(path, *groups_.reader_id); !granted) return granted;
  }
  return {};
}

std::string Daemon::description() const {
  std::string text = format_bytes(plan_.bytes()) + " for samples:";
  for (const Pool& pool : plan_.pools)
    text += " " + std::to_string(pool.count) + " x " + format_bytes(pool.bytes) + ",";
  return text + " and " + format_bytes(memory_->management().size()) + " to manage them";
}

void Daemon::write_status() {
  Status status;
  status.pid = getpid();
  status.versions = {SFT_VERSION, ICEORYX_LATEST_RELEASE_VERSION, host_protocol};
  status.since_ns = since_ns_;
  status.idle_exit_s = settings_.idle_exit.count();
  status.writers = groups_.writers;
  status.readers = groups_.readers;
  status.sample_bytes = memory_->samples().bytes;
  status.management_bytes = memory_->management().size();
  status.usage = roudi_->usage();
  const auto written = write_status_file(status);
  if (!written && status_was_written_)
    log_.warning(written.error().message + "; sftd status will show an old state");
  status_was_written_ = written.has_value();
}

Daemon::End Daemon::serve() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&signals, signal);
  const timespec timeout{0, std::chrono::nanoseconds(tick).count()};
  auto next_sweep = Clock::now() + sweep_interval;
  for (;;) {
    if (sigtimedwait(&signals, nullptr, &timeout) > 0) return End::stopped;
    check_names();
    write_status();
    const auto now = Clock::now();
    if (now >= next_sweep) {
      core::DoorbellPage::sweep();
      next_sweep = now + sweep_interval;
    }
    if (const auto end = check_idle(now)) return *end;
  }
}

std::optional<Daemon::End> Daemon::check_idle(Clock::time_point now) {
  // A young daemon waits before it starts afresh, because somebody may remove its files again and again.
  if (names_removed_ && now - began_ >= youngest_to_renew) return End::renew;
  if (!roudi_->is_idle()) {
    idle_since_.reset();
    return std::nullopt;
  }
  if (!idle_since_) idle_since_ = now;
  if (settings_.idle_exit > 0s && now - *idle_since_ >= settings_.idle_exit) return End::idle;
  if (roudi_->unaudited() == 0 || now - *idle_since_ < renewal_delay) return std::nullopt;
  log_.warning(
      "after a program was killed, its lost chunks cannot be found; sftd starts afresh with new memory");
  return End::renew;
}

/// Somebody may have removed the files while this daemon ran. Then the files with these names can belong to
/// another daemon by now, and stay.
void Daemon::remove_files(bool starts_again) {
  struct stat other {};
  const bool names_are_ours =
      daemon_lock_.is_named() && (host_file_.is_named() || lstat(host_file_path, &other) != 0);
  std::ignore = ftruncate(daemon_lock_.descriptor(), 0);  // what it says of this daemon is no longer true
  host_file_.remove();
  if (names_are_ours) remove_daemon_files(groups_.writers);
  // While the lock exists, programs do not start another daemon.
  if (!starts_again) daemon_lock_.remove();
}

namespace {
/// Returns the device of /dev/shm; 0 if it is not known.
dev_t device_of_shared_memory() {
  struct stat status {};
  return stat("/dev/shm", &status) == 0 ? status.st_dev : 0;
}
}  // namespace

/// Returns whether somebody has removed the files by which programs find this daemon and its memory. If
/// another file system was mounted over /dev/shm, nothing was removed. Then new programs say that they have
/// another /dev/shm than this daemon, and the daemon goes on to serve the old ones.
bool Daemon::names_are_removed() const {
  if (device_of_shared_memory() != shm_device_) return false;
  return !daemon_lock_.is_named() || !host_file_.is_named() ||
         std::ranges::any_of(segments_, [](const auto& segment) {
           struct stat named {};
           return lstat(segment.first.c_str(), &named) != 0 || named.st_ino != segment.second;
         });
}

void Daemon::note_segments() {
  shm_device_ = device_of_shared_memory();
  for (const std::string& name : {std::string(iox::roudi::SHM_NAME), groups_.writers}) {
    const std::string path = "/dev/shm/" + name;
    struct stat made {};
    if (lstat(path.c_str(), &made) == 0) segments_.emplace_back(path, made.st_ino);
  }
}

/// Programs release the memory of this daemon when they notice that it is gone. Then the next daemon finds
/// that memory free.
void Daemon::let_users_notice() {
  const bool idle = roudi_->is_idle();
  host_file_.unlock();
  if (!idle) std::this_thread::sleep_for(time_to_release);
}

void Daemon::check_names() {
  if (names_removed_ || !names_are_removed()) return;
  names_removed_ = true;
  log_.warning(names_are_gone(getpid()));
}

}  // namespace sft::shm
