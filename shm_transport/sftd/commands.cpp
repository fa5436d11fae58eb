#include "shm_transport/sftd/commands.h"

#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <system_error>

#include "core/platform/clock.h"
#include "shm_transport/sftd/running_daemon.h"
#include "shm_transport/sftd/status_file.h"

namespace sft::shm {

namespace {

using namespace std::chrono_literals;

// The daemon writes its status twice a second. If the status is older than this, the daemon counts as not
// answering, because even on a busy machine the delay of a status is smaller.
constexpr std::chrono::nanoseconds silence_max = 3s;

ExitCode print_error(ExitCode code, const std::string& text) {
  fmt::print(stderr, "sftd: {}\n", text);
  return code;
}

/// Writes a text to standard output at once. Returns the reason if it cannot be written; empty: it was
/// written. fmt::print() would throw an exception if the text were longer than the buffer of the stream.
std::string why_not_printed(const std::string& text) {
  const bool is_written =
      std::fwrite(text.data(), 1, text.size(), stdout) == text.size() && std::fflush(stdout) == 0;
  return is_written ? "" : std::generic_category().message(errno);
}

/// Returns the reason why the daemon does not answer; empty if it answers.
std::string why_it_does_not_answer(const RunningDaemon& daemon, const std::optional<Status>& status) {
  const std::string name = fmt::format("the daemon (pid {}) ", daemon.pid());
  if (daemon.is_stopped()) return name + "is stopped, by a signal or a debugger; continue it: kill -CONT";
  if (!status) return name + "has not written its status; is it of another version?";
  const std::chrono::nanoseconds age(core::realtime_ns() - status->usage.stamp_ns);
  if (age < silence_max) return {};
  return name + fmt::format("does not answer; it last wrote its status {:.1f} s ago",
                            std::chrono::duration<double>(age).count());
}

std::string users_of(const std::optional<Status>& status) {
  std::string users;
  if (!status) return users;
  for (const UserUse& user : status->usage.users)
    users += fmt::format("\n  {} (pid {}): {} publishers, {} subscribers", user.name, user.pid,
                         user.publishers, user.subscribers);
  return users;
}

bool ends_within(const Descriptor& process, std::chrono::milliseconds timeout) {
  pollfd end{process.get(), POLLIN, 0};
  return poll(&end, 1, static_cast<int>(timeout.count())) > 0;
}

ExitCode exit_code_of_stop(const Error& error) {
  return error.code == Errc::no_permission ? ExitCode::not_permitted : ExitCode::failed;
}

}  // namespace

ExitCode print_status(bool as_json) {
  const auto daemon = RunningDaemon::find();
  if (!daemon) return print_error(daemon.error().code, daemon.error().reason);
  const auto status = read_status_file(daemon->user());
  if (status) {
    const std::string why_not =
        why_not_printed(as_json ? to_json(*status) : to_table(*status, core::realtime_ns()));
    if (!why_not.empty()) return print_error(ExitCode::failed, "the status cannot be written: " + why_not);
  }
  const std::string reason = why_it_does_not_answer(*daemon, status);
  if (reason.empty() && !daemon->problem().empty()) return print_error(ExitCode::done, daemon->problem());
  return reason.empty() ? ExitCode::done
                        : print_error(ExitCode::no_answer,
                                      reason + (status ? "; the table above shows the last status" : ""));
}

ExitCode stop_daemon(std::chrono::milliseconds timeout) {
  const auto daemon = RunningDaemon::find();
  if (!daemon) return print_error(daemon.error().code, daemon.error().reason);
  const auto process = daemon->process();
  if (!process) return print_error(exit_code_of_stop(process.error()), process.error().message);
  const std::string users = users_of(read_status_file(daemon->user()));
  if (syscall(SYS_pidfd_send_signal, process->get(), SIGTERM, nullptr, 0) != 0)
    return print_error(ExitCode::failed,
                       fmt::format("no signal can be sent to the daemon (pid {})", daemon->pid()));
  if (!ends_within(*process, timeout)) {
    return print_error(
        ExitCode::no_answer,
        fmt::format("the daemon does not end; if it is stopped, continue it: kill -CONT {}", daemon->pid()));
  }
  const std::string ended = fmt::format("the daemon (pid {}) has ended; ", daemon->pid());
  const std::string why_not = why_not_printed(
      "sftd: " + ended +
      (users.empty() ? "no program used it" : "these programs used it, and go on over UDP:" + users) + "\n");
  if (why_not.empty()) return ExitCode::done;
  return print_error(ExitCode::failed, ended + "which programs used it cannot be written: " + why_not);
}

}  // namespace sft::shm
