#include "shm_transport/daemon/daemon_link.h"

#include <sys/stat.h>
#include <unistd.h>

#include <cctype>
#include <cstdio>
#include <utility>

#include "core/platform/random_id.h"
#include "shm_transport/daemon/accepted_daemons.h"

namespace sft::shm {

namespace {

using core::Availability;

// The pause after a successful start of a daemon. The daemon may be killed, or end by itself, as soon as it
// is ready. This pause does not grow, because there was no obstacle to the start.
constexpr std::chrono::milliseconds pause_after_a_start{500};
// The pause after a failed start if an obstacle to that start is gone. It limits the number of attempts
// that another process can cause by creating and removing files in the way again and again.
constexpr std::chrono::milliseconds shortest_pause_of_launches{200};
// The longest pause between attempts to register. Attempts cost little, and a daemon that was stopped may
// continue at any moment.
constexpr std::chrono::milliseconds longest_pause_of_registrations{1'000};

/// Returns sft_<prefix>_<pid>_<random>_<pid namespace>. This name must be unique among the processes that a
/// daemon serves.
std::string make_runtime_name(const std::string& prefix) {
  std::string name = runtime_name_stem;
  for (const char c : prefix.substr(0, 31)) name += std::isalnum(static_cast<unsigned char>(c)) ? c : '_';
  char rest[40];
  std::snprintf(rest, sizeof rest, "_%d_%08x", static_cast<int>(getpid()),
                static_cast<unsigned>(core::random_id()));
  return name + rest + pid_namespace_mark();
}

/// Returns whether a daemon of iceoryx listens at its socket in this /tmp, or whether an sftd has locked
/// its lock file there.
bool another_daemon_serves() {
  return is_locked_at(daemon_lock_path) || socket_state_at(roudi_socket_path) == SocketState::alive;
}

/// Returns a text that says why the daemon that another_daemon_serves() has found cannot be used. That
/// daemon has no host file in this /dev/shm.
std::string why_that_daemon_is_not_used(const core::TrustedAccounts& accepted) {
  struct stat socket {};
  if (const auto daemon = read_daemon_lock()) {
    if (!accepted.include_user(daemon->user)) return why_not_accepted(daemon->user);
    if (daemon->serves_this_shm()) return names_are_gone(daemon->pid);
    return "sftd is running with another /dev/shm than this program's; share it (docker run --ipc=host)";
  }
  const std::string whose =
      lstat(roudi_socket_path, &socket) == 0 ? " of " + core::account_name(socket.st_uid) : "";
  return "another daemon than sftd serves iceoryx here (iox-roudi?)" + whose +
         "; stop that daemon, and sftd will be started";
}

std::string daemon_name(pid_t pid) { return "sftd (pid " + std::to_string(pid) + ")"; }

}  // namespace

DaemonLink::State DaemonLink::advance(const ShmOptions& options,
                                      const std::shared_ptr<IceoryxRuntime>& runtime, Clock::time_point now) {
  if (advancing_.test_and_set(std::memory_order_acquire)) return current();
  std::shared_ptr<Session> session;  // keeps a new session alive until the caller has it
  switch (phase_) {
    case Phase::looking:
      look(options, now);
      break;
    case Phase::launching:
      await_launch(options, now);
      break;
    case Phase::registering:
      session = await_registration(runtime, now);
      break;
    case Phase::in_session:
      session = watch_session();
      break;
  }
  const State state = current();
  advancing_.clear(std::memory_order_release);
  return state;
}

void DaemonLink::look(const ShmOptions& options, Clock::time_point now) {
  if (!functions_are_replaced_) return publish(Availability::unavailable, not_replaced);
  const core::TrustedAccounts accepted =
      accepted_daemons(user_ids(options.daemon_users).value_or(std::vector<uid_t>{}));
  HostMonitor::Look found = HostMonitor::look(accepted);
  if (found.finding == HostMonitor::Finding::starting) return await_host_file(options, now);
  deadline_.reset();
  if (found.finding == HostMonitor::Finding::alive) {
    const auto& token = found.monitor->file().token;
    if (std::exchange(registered_with_, token) != token) registering_.succeeded();
    if (registering_.due(now)) begin_registration(options, std::move(*found.monitor), now);
  } else if (found.finding == HostMonitor::Finding::foreign) {
    publish(Availability::unavailable, why_not_accepted(found.user));
  } else if (const auto lock = read_daemon_lock();
             lock && lock->pid == 0 && accepted.include_user(lock->user)) {
    publish(Availability::starting, "sftd is starting or ending");
  } else if (another_daemon_serves()) {
    publish(Availability::unavailable, why_that_daemon_is_not_used(accepted));
  } else if (!options.start_daemon) {
    publish(Availability::unavailable, "no sftd is running, and starting one is turned off; run sftd",
            nullptr, true);
  } else if (may_launch(now)) {
    launch(options, now);
  } else {
    publish(Availability::unavailable, launching_.reason());
  }
}

void DaemonLink::await_host_file(const ShmOptions& options, Clock::time_point now) {
  if (!deadline_) deadline_ = now + options.start_deadline;
  if (now < *deadline_) {
    publish(Availability::starting, "sftd is starting");
  } else {
    publish(Availability::unavailable,
            "sftd is starting but does not get ready; is it stopped? Look for it with: pgrep -a sftd");
  }
}

/// Returns whether a daemon should be started: if the pause is over, or if an obstacle to the last attempt
/// is gone.
bool DaemonLink::may_launch(Clock::time_point now) const {
  if (launching_.due(now)) return true;
  return launch_failed_at_ && now >= *launch_failed_at_ + shortest_pause_of_launches &&
         LaunchObstacles::look(files_of_daemon_).have_eased_since(obstacles_);
}

void DaemonLink::launch(const ShmOptions& options, Clock::time_point now) {
  obstacles_ = LaunchObstacles::look(files_of_daemon_);
  launch_failed_at_.reset();
  auto launched = DaemonLaunch::begin(options, places_);
  if (!launched) return give_up(launching_, launched.error().message, now);
  launch_.emplace(std::move(*launched));
  deadline_ = now + options.start_deadline;
  phase_ = Phase::launching;
  publish(Availability::starting, "this program starts sftd");
}

void DaemonLink::await_launch(const ShmOptions& options, Clock::time_point now) {
  const auto outcome = launch_->poll();
  if (!outcome && now >= *deadline_) {
    launch_.reset();
    return give_up_launch("sftd was started but does not get ready; is the machine overloaded?", now);
  }
  if (!outcome) return;
  launch_.reset();
  if (!outcome->error.empty()) return give_up_launch(outcome->error, now);
  phase_ = Phase::looking;
  deadline_.reset();
  // Without this pause, a daemon that ends as soon as it is ready would be started again and again.
  launching_.failed("sftd has ended again after it was started; it will be started once more within 1 s", now,
                    pause_after_a_start);
  look(options, now);
}

/// Files and a lack of space that have appeared since sftd was started count as obstacles, too, because
/// they may have stopped sftd.
void DaemonLink::give_up_launch(const std::string& reason, Clock::time_point now) {
  obstacles_.add(LaunchObstacles::look(files_of_daemon_));
  launch_failed_at_ = now;
  give_up(launching_, reason, now);
}

void DaemonLink::begin_registration(const ShmOptions& options, HostMonitor monitor, Clock::time_point now) {
  if (monitor.file().protocol != host_protocol) {
    return give_up(registering_,
                   daemon_name(monitor.file().pid) +
                       " is of another version than this program; end it (sftd stop), and start the sftd of "
                       "this program's "
                       "version",
                   now);
  }
  auto channel = RoudiChannel::open(make_runtime_name(options.runtime_name_prefix), monitor.user());
  if (!channel) {
    return give_up(registering_,
                   daemon_name(monitor.file().pid) + " cannot be reached: " + channel.error().message, now);
  }
  channel_ = std::move(*channel);
  monitor_.emplace(std::move(monitor));
  deadline_ = now + options.connect_deadline;
  phase_ = Phase::registering;
  publish(Availability::starting, "this program registers with " + daemon_name(monitor_->file().pid));
}

std::shared_ptr<Session> DaemonLink::await_registration(const std::shared_ptr<IceoryxRuntime>& runtime,
                                                        Clock::time_point now) {
  const auto answer = channel_->poll_registration();
  const std::string name = daemon_name(monitor_->file().pid);
  if (!answer) {
    give_up(registering_, answer.error().message, now);
  } else if (!monitor_->daemon_lives()) {
    give_up(registering_, name + " ended while this process registered", now);
  } else if (!*answer && now >= *deadline_) {
    // A stopped daemon answers the request when it continues.
    deadline_ = Clock::time_point::max();
    publish(Availability::unavailable,
            name +
                " does not answer; is it stopped, or is it built with another iceoryx "
                "than " ICEORYX_LATEST_RELEASE_VERSION "?");
  } else if (*answer) {
    auto session = Session::open(runtime, std::move(*monitor_), std::move(channel_), **answer);
    monitor_.reset();
    if (!session) {
      give_up(registering_, session.error().message, now);
      return nullptr;
    }
    launching_.succeeded();
    registering_.succeeded();
    phase_ = Phase::in_session;
    publish(Availability::ready, "iceoryx " ICEORYX_LATEST_RELEASE_VERSION ", hosted by " + name, *session);
    return *session;
  }
  return nullptr;
}

std::shared_ptr<Session> DaemonLink::watch_session() {
  std::shared_ptr<Session> session = current().session;
  if (session != nullptr && session->daemon_lives()) {
    session->collect();
    return session;
  }
  // If there is no session, its last user has released it, and its destructor has sent the daemon the
  // goodbye.
  phase_ = Phase::looking;
  if (session != nullptr) session->lose();
  publish(Availability::starting,
          session != nullptr ? daemon_name(session->daemon_pid()) + " is gone" : looking_for_daemon);
  return nullptr;
}

void DaemonLink::give_up(core::Retry& attempt, const std::string& reason, Clock::time_point now) {
  channel_.reset();
  monitor_.reset();
  deadline_.reset();
  phase_ = Phase::looking;
  attempt.failed(reason, now,
                 &attempt == &registering_ ? longest_pause_of_registrations : core::Retry::pause_max);
  publish(Availability::unavailable, reason);
}

void DaemonLink::publish(Availability availability, std::string description, std::shared_ptr<Session> session,
                         bool lacks_daemon) {
  const core::Lock lock(mutex_);
  availability_ = availability;
  lacks_daemon_ = lacks_daemon;
  description_ = std::move(description);
  session_ = session;
}

DaemonLink::State DaemonLink::current() const {
  const core::Lock lock(mutex_);
  std::shared_ptr<Session> session = session_.lock();
  // A session that all its users have released cannot be shared any more.
  if (availability_ == Availability::ready && session == nullptr) return {Availability::starting, nullptr};
  return {availability_, std::move(session)};
}

std::string DaemonLink::description() const {
  const core::Lock lock(mutex_);
  return description_;
}

bool DaemonLink::lacks_daemon() const {
  const core::Lock lock(mutex_);
  return lacks_daemon_;
}

}  // namespace sft::shm
