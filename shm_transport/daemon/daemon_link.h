// The way from "no shared memory" to a session and back: looks for the daemon, starts one, registers, and
// notices its death. A state machine that never waits; it is advanced by whoever polls.
#pragma once

#include <array>
#include <atomic>
#include <chrono>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "core/platform/retry.h"
#include "core/seam/transport.h"
#include "shm_transport/daemon/daemon_launch.h"
#include "shm_transport/daemon/launch_obstacles.h"
#include "shm_transport/host/session.h"
#include "shm_transport/host/shm_options.h"

namespace sft::shm {

class DaemonLink {
 public:
  struct State {
    core::Availability availability = core::Availability::starting;
    std::shared_ptr<Session> session{};  ///< exactly while ready
  };

  /// Any thread. Where another thread is advancing it just now, the state is as that one last left it.
  /// The sessions keep `runtime`, and with it whatever owns this link.
  State advance(const ShmOptions& options, const std::shared_ptr<IceoryxRuntime>& runtime,
                Clock::time_point now);

  /// One sentence on that state.
  std::string description() const;
  /// No daemon is running, and the options forbid to start one. Any thread.
  bool lacks_daemon() const;

 private:
  enum class Phase { looking, launching, registering, in_session };

  void look(const ShmOptions& options, Clock::time_point now);
  void launch(const ShmOptions& options, Clock::time_point now);
  bool may_launch(Clock::time_point now) const;
  void give_up_launch(const std::string& reason, Clock::time_point now);
  void await_launch(const ShmOptions& options, Clock::time_point now);
  void await_host_file(const ShmOptions& options, Clock::time_point now);
  void begin_registration(const ShmOptions& options, HostWatch watch, Clock::time_point now);
  std::shared_ptr<Session> await_registration(const std::shared_ptr<IceoryxRuntime>& runtime,
                                              Clock::time_point now);
  std::shared_ptr<Session> watch_session();

  void give_up(core::Retry& attempt, const std::string& reason, Clock::time_point now);
  void publish(core::Availability availability, std::string description,
               std::shared_ptr<Session> session = nullptr, bool lacks_daemon = false);
  State current() const;

  // Of the thread that advances, which is whoever took the flag.
  std::atomic_flag advancing_ = ATOMIC_FLAG_INIT;
  Phase phase_ = Phase::looking;
  std::optional<DaemonLaunch> launch_;
  std::optional<HostWatch> watch_;
  std::unique_ptr<RoudiChannel> channel_;
  std::optional<Clock::time_point> deadline_;  ///< of what the phase waits for
  core::Retry launching_;
  std::vector<std::string> files_of_daemon_;    ///< found out before the first attempt to start one
  LaunchObstacles obstacles_;                   ///< to the last attempt
  std::optional<Clock::time_point> failed_at_;  ///< the last attempt, where obstacles may be why
  core::Retry registering_;                     ///< with the daemon of this token: another one owes nothing
  std::array<std::uint8_t, 16> registered_with_{};

  mutable std::mutex mutex_;  // guards what is seen from outside
  core::Availability availability_ = core::Availability::starting;
  std::string description_ = "looks for sftd";
  bool lacks_daemon_ = false;
  std::weak_ptr<Session> session_;  ///< held by transports and ports, not by the link
};

}  // namespace sft::shm
