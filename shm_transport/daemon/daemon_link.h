// The connection of this process to its daemon. DaemonLink looks for the daemon, starts a daemon if none
// runs, registers this process, and notices when the daemon is gone. It is a state machine that never
// waits. The transports of the process advance it at each poll.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/platform/retry.h"
#include "core/seam/transport.h"
#include "core/sync/mutex.h"
#include "shm_transport/daemon/daemon_launch.h"
#include "shm_transport/daemon/daemon_search.h"
#include "shm_transport/daemon/launch_obstacles.h"
#include "shm_transport/host/replaced_functions.h"
#include "shm_transport/host/session.h"
#include "shm_transport/host/shm_options.h"

namespace sft::shm {

class DaemonLink {
 public:
  struct State {
    core::Availability availability = core::Availability::starting;
    std::shared_ptr<Session> session{};  ///< not null exactly while shared memory is ready
  };

  /// Performs the next step, and returns the state. Any thread may call this. While another thread is in
  /// this function, a call only returns the state after the last step. Each session shares the ownership of
  /// `runtime`, and so keeps the object that owns this link alive.
  State advance(const ShmOptions& options, const std::shared_ptr<IceoryxRuntime>& runtime,
                Clock::time_point now);

  /// Returns a sentence that describes the state.
  std::string description() const;
  /// Returns whether no daemon is running and the options forbid starting one. Any thread may call this.
  bool lacks_daemon() const;

 private:
  static constexpr const char* looking_for_daemon = "this program looks for sftd";
  enum class Phase { looking, launching, registering, in_session };

  void look(const ShmOptions& options, Clock::time_point now);
  void launch(const ShmOptions& options, Clock::time_point now);
  bool may_launch(Clock::time_point now) const;
  void give_up_launch(const std::string& reason, Clock::time_point now);
  void await_launch(const ShmOptions& options, Clock::time_point now);
  void await_host_file(const ShmOptions& options, Clock::time_point now);
  void begin_registration(const ShmOptions& options, HostMonitor monitor, Clock::time_point now);
  std::shared_ptr<Session> await_registration(const std::shared_ptr<IceoryxRuntime>& runtime,
                                              Clock::time_point now);
  std::shared_ptr<Session> watch_session();

  void give_up(core::Retry& attempt, const std::string& reason, Clock::time_point now);
  void publish(core::Availability availability, std::string description,
               std::shared_ptr<Session> session = nullptr, bool lacks_daemon = false);
  State current() const;

  // Only the thread that has set this flag uses the members from here to `mutex_`.
  std::atomic_flag advancing_ = ATOMIC_FLAG_INIT;
  // The possible paths of sftd's file are determined when the first node opens. Determining them calls the
  // dynamic loader, which may hold its lock for long, and advance() must not wait for that lock.
  const DaemonPlaces places_ = DaemonPlaces::of_this_process();
  /// The result of functions_are_replaced(), which does not change while the process runs.
  const bool functions_are_replaced_ = functions_are_replaced();
  Phase phase_ = Phase::looking;
  std::optional<DaemonLaunch> launch_;
  std::optional<HostMonitor> monitor_;
  std::unique_ptr<RoudiChannel> channel_;
  /// The time at which the current phase fails if it has not ended.
  std::optional<Clock::time_point> deadline_;
  core::Retry launching_;
  // These names are also determined when the first node opens, because the lookup of a group's name may
  // take long if the server of the groups does not answer.
  const std::vector<std::string> files_of_daemon_ = files_of_own_daemon();
  LaunchObstacles obstacles_;  ///< obstacles to the last attempt to start a daemon
  /// The time of the last failed attempt. Empty if no attempt has failed, or if obstacles cannot be the
  /// reason of the failure.
  std::optional<Clock::time_point> launch_failed_at_;
  /// The pauses between attempts to register with the daemon that `registered_with_` names. Another daemon
  /// is tried at once.
  core::Retry registering_;
  /// The token of the daemon that was last asked to register this process.
  std::array<std::uint8_t, 16> registered_with_{};

  // Guards the following members. Any thread may call the functions that read them.
  mutable core::Mutex mutex_;
  core::Availability availability_ SFT_GUARDED_BY(mutex_) = core::Availability::starting;
  std::string description_ SFT_GUARDED_BY(mutex_) = looking_for_daemon;
  bool lacks_daemon_ SFT_GUARDED_BY(mutex_) = false;
  std::weak_ptr<Session> session_ SFT_GUARDED_BY(mutex_);  ///< owned by transports and ports, not by the link
};

}  // namespace sft::shm
