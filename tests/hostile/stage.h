// Two hosts with honest programs, a third host for attackers on the network, and the checks of the honest
// programs: they stay alive, samples arrive while an act lasts, and soon after the act all pairs are served
// as before.
#pragma once

#include <array>
#include <chrono>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "tests/hostile/act.h"
#include "tests/pairs/host.h"
#include "tests/pairs/network.h"
#include "tests/pairs/peer.h"

namespace sft::hostile {

using Clock = std::chrono::steady_clock;
using Ms = std::chrono::milliseconds;

/// When the act begins, relative to the start of the honest programs.
enum class Moment : std::uint8_t { before_they_start, while_they_start, after_they_started };
inline constexpr std::array moments{Moment::after_they_started, Moment::while_they_start,
                                    Moment::before_they_start};
std::string_view to_string(Moment moment);

/// The effect of an act on the honest programs.
struct Outcome {
  std::vector<std::string> complaints{};  ///< sentences; empty if there was no fault
  /// The time from the end of the act until each pair was served as before; empty if this did not happen in
  /// time.
  std::optional<Ms> recovery{};
  /// The time from the end of the act until `sftd status` answered and each pair was served; empty if this
  /// was not checked or did not happen in time.
  std::optional<Ms> command_line{};
};

/// The honest programs that have certificates of DDS Security (tools/security).
enum class Certificates : std::uint8_t { none, all };

/// A publisher with a subscriber in shared memory, and with two subscribers by UDP on another host: a
/// reliable one and a best-effort one.
class Stage {
 public:
  /// Returns the reason why a stage cannot be set up on this system; empty if it can. REQUIRES: the program
  /// is isolated (isolated_host.h).
  static std::string refusal();

  explicit Stage(std::uint64_t seed, Certificates certificates = Certificates::none);
  ~Stage();
  Stage(const Stage&) = delete;
  Stage& operator=(const Stage&) = delete;

  /// Starts the honest programs that do not run. Returns false if not all of their pairs are served in
  /// time.
  bool start();
  /// Performs an act, and starts new honest programs if `moment` requires that. The act continues for
  /// `length` once all honest programs are running.
  Outcome perform(const Entry& entry, Moment moment, Ms length);
  /// Ends the honest programs. Returns complaints about those that crashed or hung.
  std::vector<std::string> end();

  /// Kills the publisher and starts another one. Returns the time until all pairs are served. Any recovery
  /// that needs a new publisher takes at least this time.
  std::optional<Ms> restart_publisher();

 private:
  struct Pair;
  class Actor;

  void launch();
  test::json options(bool start_daemon) const;
  Harm harm_of(const Entry& entry) const;
  bool look(Pair& pair);
  bool all_served(Harm harm = Harm::none);
  void note_stopped(const Entry& entry, Outcome& outcome);
  void expect_samples(Outcome& outcome);
  void await_recovery(const Entry& entry, Clock::time_point ended, Outcome& outcome);
  void await_command_line(const Entry& entry, Clock::time_point ended, Outcome& outcome);
  std::string state();

  std::uint64_t seed_;
  // Declared before the hosts, because the hosts copy the mounts that the next two members make.
  test::Account honest_;
  const Certificates certificates_;
  test::Network network_;
  test::Host here_;
  test::Host there_;
  test::Host elsewhere_;
  int publishers_ = 0;  ///< number of publishers started
  std::unique_ptr<test::Peer> publisher_;
  std::vector<std::unique_ptr<Pair>> pairs_;
};

}  // namespace sft::hostile
