#include "shm_transport/sftd/daemon.h"

#include <signal.h>
#include <sys/random.h>
#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <thread>

#include "core/doorbell.h"
#include "shm_transport/host_file.h"
#include "shm_transport/sftd/stale_files.h"

namespace sft::shm {

namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr std::size_t MiB = 1 << 20;
constexpr std::size_t smallest_shm_bytes = 128 * MiB;
constexpr std::size_t default_pool_bytes = 320 * MiB;
constexpr auto tick = 500ms;
constexpr auto sweep_interval = 10s;
// Long enough for a program that crashed to be started again by whoever looks after it.
constexpr auto renewal_delay = 2s;

struct Space {
  std::size_t total = 0;
  std::size_t free = 0;
};

Space shm_space() {
  struct statvfs status {};
  if (statvfs("/dev/shm", &status) != 0) return {};
  return {status.f_blocks * status.f_frsize, status.f_bavail * status.f_frsize};
}

tl::unexpected<StartFailure> refuse(ExitCode code, std::string message) {
  return tl::unexpected(StartFailure{code, std::move(message)});
}

tl::unexpected<StartFailure> refuse_for_space(const Space& space, std::size_t needed) {
  return refuse(
      ExitCode::no_space,
      "/dev/shm has " + format_bytes(space.total) + ", of which " + format_bytes(space.free) +
          " are free, and shared memory needs " + format_bytes(needed) +
          "; enlarge it (docker run --shm-size=512m, or mount -o remount,size=512m /dev/shm), until then "
          "samples go over UDP");
}

/// How much of the free space goes to samples: what was asked for, or half of it up to a default.
tl::expected<PoolPlan, StartFailure> choose_pools(const DaemonSettings& settings,
                                                  const std::string& segment_name) {
  const Space space = shm_space();
  if (space.total < smallest_shm_bytes) return refuse_for_space(space, smallest_shm_bytes);
  const std::size_t wanted = settings.pool_bytes.value_or(default_pool_bytes);
  const std::size_t management = HostMemory::management_bytes(make_config(plan_pools(wanted), segment_name));
  const std::size_t least = settings.pool_bytes.value_or(2 * smallest_budget_bytes);
  if (space.free < management + least) return refuse_for_space(space, management + least);
  const std::size_t half = (space.free - management) / 2;
  return plan_pools(settings.pool_bytes ? wanted : std::min(half, wanted));
}

std::string describe(const PoolPlan& plan) {
  std::string text = format_bytes(plan.bytes()) + " for samples:";
  for (const Pool& pool : plan.pools)
    text += " " + std::to_string(pool.count) + " x " + format_bytes(pool.bytes) + ",";
  text.pop_back();
  return text;
}

/// Whatever iceoryx meets later concerns one client, and ends in an answer to it. While it starts, it would
/// go on with memory that it could not get.
iox::cxx::GenericRAII log_errors(const Log& log) {
  static const Log* sink = nullptr;
  sink = &log;
  static const iox::HandlerFunction handler = [](const iox::Error error, const std::function<void()>&,
                                                 const iox::ErrorLevel level) {
    const auto severity = level == iox::ErrorLevel::MODERATE ? LogLevel::debug : LogLevel::warning;
    sink->write(severity, std::string("iceoryx reports ") + iox::ErrorHandler::toString(error));
  };
  return iox::ErrorHandler::setTemporaryErrorHandler(handler);
}

template <class Condition>
bool wait_until(Clock::time_point deadline, Condition condition) {
  while (!condition()) {
    if (Clock::now() >= deadline) return false;
    std::this_thread::sleep_for(1ms);
  }
  return true;
}

}  // namespace

Daemon::Daemon(const DaemonSettings& settings, const Log& log, FileLock only_one, FileLock host_file,
               std::string segment_name)
    : settings_(settings),
      log_(log),
      only_one_(std::move(only_one)),
      host_file_(std::move(host_file)),
      segment_name_(std::move(segment_name)),
      error_handler_(log_errors(log)) {}

/// The order matters: our locks come before anything of iceoryx, which would abort where it finds a daemon
/// running.
Daemon::Started Daemon::start(const DaemonSettings& settings, const Log& log) {
  auto only_one = FileLock::take(daemon_lock_path);
  if (!only_one) {
    if (only_one.error().code == Errc::address_in_use) return refuse(ExitCode::running, "already running");
    return refuse(ExitCode::failed,
                  only_one.error().message + "; another user's sftd may have left it: remove it");
  }
  if (listener_at(roudi_socket_path) != Listener::gone) {
    return refuse(
        ExitCode::foreign_daemon,
        "another iceoryx daemon (iox-roudi) is running; stop it: sftd serves SFT's programs instead, and the "
        "two cannot share /tmp/roudi");
  }
  remove_segment_of_the_dead();
  auto host_file = FileLock::take(host_file_path);
  if (!host_file) {
    return refuse(ExitCode::failed,
                  host_file.error().message +
                      "; an sftd of another container may use the same /dev/shm, which needs the same "
                      "/tmp too");
  }
  auto segment_name = data_segment_name();
  if (!segment_name) return refuse(ExitCode::failed, segment_name.error().message);

  std::unique_ptr<Daemon> daemon(
      new Daemon(settings, log, std::move(*only_one), std::move(*host_file), std::move(*segment_name)));
  remove_daemon_files(daemon->segment_name_);
  remove_dead_sockets();
  core::DoorbellPage::sweep();
  auto plan = choose_pools(settings, daemon->segment_name_);
  if (!plan) return tl::unexpected(plan.error());
  if (auto failure = daemon->host(*plan)) return tl::unexpected(*failure);
  return daemon;
}

std::optional<StartFailure> Daemon::host(const PoolPlan& plan) {
  auto lock = iox::posix::FileLock::create(iox::roudi::ROUDI_LOCK_NAME);
  if (lock.has_error()) {
    return StartFailure{ExitCode::foreign_daemon, "another iceoryx daemon is about to start; stop it"};
  }
  roudi_lock_.emplace(std::move(lock.value()));
  auto memory = HostMemory::make(make_config(plan, segment_name_));
  if (!memory) return StartFailure{ExitCode::no_space, memory.error().message};
  memory_ = std::move(*memory);
  ports_ = std::make_unique<iox::roudi::PortManager>(memory_.get());
  roudi_ = std::make_unique<RoudiHost>(*memory_, *ports_, log_);
  if (!announce())
    return StartFailure{ExitCode::failed, "iceoryx does not begin to serve; is /tmp writable?"};
  log_.info(describe(plan));
  if (!plan.remark.empty()) log_.warning(plan.remark);
  return std::nullopt;
}

bool Daemon::announce() {
  if (!wait_until(Clock::now() + 5s, [] { return listener_at(roudi_socket_path) == Listener::alive; }))
    return false;
  HostFile file;
  file.pid = getpid();
  file.port_pool_offset = memory_->port_pool_offset();
  file.segment = segment_name_;
  if (getrandom(file.token.data(), file.token.size(), 0) != static_cast<ssize_t>(file.token.size()))
    return false;
  const std::string text = format(file);
  return pwrite(host_file_.descriptor(), text.data(), text.size(), 0) == static_cast<ssize_t>(text.size()) &&
         dprintf(only_one_.descriptor(), "%d\n", static_cast<int>(getpid())) > 0;
}

Daemon::End Daemon::serve() {
  sigset_t signals;
  sigemptyset(&signals);
  for (const int signal : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&signals, signal);
  const timespec timeout{0, std::chrono::nanoseconds(tick).count()};
  auto next_sweep = Clock::now() + sweep_interval;
  for (;;) {
    if (sigtimedwait(&signals, nullptr, &timeout) > 0) return End::stopped;
    const auto now = Clock::now();
    if (now >= next_sweep) {
      core::DoorbellPage::sweep();
      next_sweep = now + sweep_interval;
    }
    if (const auto end = check_idle(now)) return *end;
  }
}

std::optional<Daemon::End> Daemon::check_idle(Clock::time_point now) {
  if (!roudi_->is_idle()) {
    idle_since_.reset();
    return std::nullopt;
  }
  if (!idle_since_) idle_since_ = now;
  if (settings_.idle_exit > 0s && now - *idle_since_ >= settings_.idle_exit) return End::idle;
  if (roudi_->deaths() == 0 || now - *idle_since_ < renewal_delay) return std::nullopt;
  log_.info("up to " + std::to_string(roudi_->deaths()) +
            " chunks may be lost to killed programs; starts afresh");
  return End::renew;
}

void Daemon::remove_traces() {
  host_file_.remove();
  remove_daemon_files(segment_name_);
  only_one_.remove();
}

}  // namespace sft::shm
