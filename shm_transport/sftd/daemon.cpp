#include "shm_transport/sftd/daemon.h"

#include <signal.h>
#include <sys/random.h>
#include <unistd.h>

#include <thread>

#include "core/platform/clock.h"
#include "core/platform/doorbell.h"
#include "core/platform/process_limits.h"
#include "core/seam/transport.h"
#include "shm_transport/daemon/launch_obstacles.h"
#include "shm_transport/host/access.h"
#include "shm_transport/host/host_file.h"
#include "shm_transport/host/iceoryx.h"
#include "shm_transport/host/replaced_functions.h"
#include "shm_transport/sftd/other_daemons.h"
#include "shm_transport/sftd/pool_choice.h"
#include "shm_transport/sftd/stale_files.h"
#include "shm_transport/sftd/status_file.h"
#include "shm_transport/sftd/surroundings.h"
#include "shm_transport/sftd/wait_until.h"

namespace sft::shm {

namespace {

using Clock = std::chrono::steady_clock;
using namespace std::chrono_literals;

constexpr auto tick = 500ms;
constexpr auto sweep_interval = 10s;
// A daemon that has a reason to start afresh does so after this time without clients. In this time a
// service manager can restart a program that has crashed.
constexpr auto renewal_delay = 2s;
// The age below which a daemon does not start afresh.
constexpr auto youngest_to_renew = 1s;
// The time in which all nodes release the memory of a daemon that is gone. Nodes look for their daemon
// regularly, and release its memory when it is gone. A node that gets samples from that memory does so at
// once.
constexpr auto time_to_release = core::Transport::poll_pause_max + 200ms;

/// The number of descriptors that sftd needs. For each process it has one descriptor to watch the process,
/// and another descriptor to answer it. In addition, it has fewer than `own_descriptors` descriptors.
constexpr std::size_t descriptors_per_process = 2, own_descriptors = 40;

ExitCode exit_code_of_start(const Error& error) {
  return error.code == Errc::invalid_argument ? ExitCode::bad_config : ExitCode::failed;
}

}  // namespace

Daemon::Daemon(const DaemonSettings& settings, const Log& log, OwnFiles files, Groups groups)
    : settings_(settings),
      log_(log),
      files_(std::move(files)),
      groups_(std::move(groups)),
      since_ns_(core::realtime_ns()),
      errors_(log) {}

/// The order matters: this daemon takes its locks before it touches any file of iceoryx, because iceoryx
/// aborts if it finds another daemon. Only locks and sockets show whether a daemon lives. All other files
/// are leftovers.
Daemon::Started Daemon::start(const DaemonSettings& settings, const Log& log, EndProcess end) {
  if (!functions_are_replaced()) return refuse(ExitCode::failed, not_replaced);
  if (const std::string lacking = Surroundings{}.lacking(); !lacking.empty())
    return refuse(ExitCode::failed, "sftd cannot start: " + lacking);
  const std::size_t descriptors = own_descriptors + descriptors_per_process * settings.limits.processes;
  if (const auto enough = core::raise_inherited_limits(descriptors); !enough)
    return refuse(ExitCode::failed,
                  "sftd takes the limits over from what starts it: " + enough.error().message +
                      "; or start sftd by itself, before this program");
  if (const auto large_enough = core::check_file_size(smallest_shm_bytes); !large_enough)
    return refuse(ExitCode::no_space, large_enough.error().message);
  auto groups = take_up_groups(settings.access);
  if (!groups) return refuse(exit_code_of_start(groups.error()), groups.error().message);
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
  OwnFiles files(std::move(*daemon_lock), std::move(*host_file), groups->writers);
  std::unique_ptr<Daemon> daemon(new Daemon(settings, log, std::move(files), std::move(*groups)));
  if (const auto remaining = remove_daemon_files(daemon->groups_.writers); !remaining.empty())
    return refuse(ExitCode::failed, in_the_way(remaining));
  remove_dead_sockets();
  core::DoorbellPage::sweep();
  auto plan = choose_pools(settings, daemon->groups_);
  if (!plan) return tl::unexpected(plan.error());
  if (const auto large_enough = core::check_file_size(plan->bytes()); !large_enough)
    return refuse(ExitCode::no_space, large_enough.error().message);
  daemon->errors_.end_process_with([&daemon, &end](const std::string& text) {
    daemon->remove_files(false);
    end({ExitCode::failed, "sftd cannot start: " + text +
                               "; are /tmp and /dev/shm writable, and is there space left? sftd --foreground "
                               "--log-level=debug says more"});
  });
  auto failure = daemon->host(*plan);
  daemon->errors_.end_process_with({});
  if (failure) {
    daemon->end_hosting();
    daemon->remove_files(false);
    return tl::unexpected(*failure);
  }
  return daemon;
}

/// Ends iceoryx before the files are removed. As soon as the files are gone, another daemon may start. If
/// iceoryx ended only after that, it would remove the socket and the memory of the other daemon, because
/// they have the same names. No program can still use this daemon, because none knows it yet.
void Daemon::end_hosting() {
  roudi_.reset();
  ports_.reset();
  memory_.reset();
  roudi_lock_.reset();
}

std::optional<StartFailure> Daemon::host(const PoolPlan& plan) {
  auto lock = iox::posix::FileLock::create(iox::roudi::ROUDI_LOCK_NAME);
  if (lock.has_error()) {
    return StartFailure{ExitCode::foreign_daemon,
                        "another iceoryx daemon (iox-roudi) is starting; stop that daemon"};
  }
  roudi_lock_.emplace(std::move(lock.value()));
  auto memory = HostMemory::make(plan, groups_);
  if (!memory) return StartFailure{ExitCode::no_space, memory.error().message};
  memory_ = std::move(*memory);
  ports_ = std::make_unique<iox::roudi::PortManager>(memory_.get());
  roudi_ = std::make_unique<RoudiHost>(*memory_, *ports_, groups_, settings_.limits, log_);
  plan_ = plan;
  const auto serves = [] { return socket_state_at(roudi_socket_path) == SocketState::alive; };
  if (!wait_until(5s, serves))
    return StartFailure{ExitCode::failed, "iceoryx has made no socket at /tmp/roudi; is /tmp writable?"};
  if (const auto admitted = admit_readers(); !admitted)
    return StartFailure{ExitCode::failed, "the group " + groups_.readers +
                                              " cannot be given rights to read: " + admitted.error().message};
  files_.note_segments();
  if (!announce())
    return StartFailure{ExitCode::failed, std::string(host_file_path) + " or " + daemon_lock_path +
                                              " could not be written; is there space left?"};
  if (const auto started = clearer_.start(memory_->take_files()); !started)
    log_.warning("the first samples will be late: " + started.error().message);
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
  file.segment_bytes = memory_->samples().memory.size();
  file.readers = groups_.reader_id;
  if (getrandom(file.token.data(), file.token.size(), 0) != static_cast<ssize_t>(file.token.size()))
    return false;
  return files_.announce(file);
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
  text += " and " + format_bytes(memory_->management().size()) + " to manage them";
  const std::size_t on_demand = plan_.bytes_on_demand();
  return on_demand == 0 ? text : text + "; " + format_bytes(on_demand) + " of it is taken when it is used";
}

void Daemon::write_status() {
  Status status;
  status.pid = getpid();
  status.versions = {SFT_VERSION, ICEORYX_LATEST_RELEASE_VERSION, host_protocol};
  status.since_ns = since_ns_;
  status.idle_exit_s = settings_.idle_exit.count();
  status.writers = groups_.writers;
  status.readers = groups_.readers;
  status.sample_bytes = memory_->samples().memory.size();
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
    check_files();
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
  // A young daemon waits before it starts afresh, because its files may be removed again and again.
  if (files_removed_ && now - began_ >= youngest_to_renew) return End::renew;
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

/// Waits until the programs have released the memory of this daemon, so that the next daemon finds that
/// memory free. A program releases the memory when it notices that the daemon is gone, and then has closed
/// the socket for this daemon's answers. If the name of a socket was removed, it is not visible whether the
/// socket is closed, and the daemon waits for the whole time.
void Daemon::let_users_notice() {
  using enum SocketState;
  std::vector<std::string> sockets;
  for (const ClientTable::Client& client : roudi_->clients()) sockets.push_back("/tmp/" + client.name);
  std::vector<std::string> silent = sockets;
  const auto state_of = [](const std::string& path) { return socket_state_at(path.c_str()); };
  std::erase_if(silent, [&](const std::string& path) { return state_of(path) == alive; });
  files_.unlock_host_file();
  const auto released = [&] {
    std::erase_if(sockets, [&](const std::string& path) { return state_of(path) == gone; });
    return sockets.empty() && silent.empty();
  };
  wait_until(time_to_release, released, 10ms);
}

void Daemon::check_files() {
  if (files_removed_ || !files_.are_removed()) return;
  files_removed_ = true;
  log_.warning(names_are_gone(getpid()));
}

}  // namespace sft::shm
