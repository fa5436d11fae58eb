#include "shm_transport/sftd/other_daemons.h"

#include <sys/stat.h>

#include <string>

#include "core/platform/trusted_file.h"
#include "shm_transport/daemon/accepted_daemons.h"
#include "shm_transport/host/host_file.h"
#include "shm_transport/sftd/wait_until.h"

namespace sft::shm {

/// The host file of a daemon appears in /dev/shm a moment after its lock, so this function waits for the
/// file. The programs of this account do not accept the daemon of another user's account.
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
    return HostMonitor::look({.everybody = true}).finding != HostMonitor::Finding::absent ||
           !is_locked_at(daemon_lock_path);
  };
  if (wait_until(std::chrono::seconds(1), settled)) return refuse(ExitCode::done, "already running");
  return refuse(
      ExitCode::failed,
      "an sftd with another /dev/shm has the same /tmp; share both directories with its container, or "
      "neither");
}

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

}  // namespace sft::shm
