// An act is an attack by a hostile program on honest programs, or an accident that has similar effects. It
// begins, continues for a while, and ends. Each act is a function that returns these three parts, and has a
// line in the table of acts.
#pragma once

#include <sys/types.h>

#include <cstdint>
#include <functional>
#include <random>
#include <span>
#include <string>
#include <string_view>

namespace sft::hostile {

using Random = std::mt19937_64;

/// The parts of an act. Parts that are empty functions do nothing.
struct Act {
  std::function<void()> begin{};
  /// Called every 10 ms while the act lasts.
  std::function<void()> go_on{};
  /// Stops everything that would otherwise continue by itself. Damage is not repaired.
  std::function<void()> end{};
  /// Returns a sentence about what the attacker has gained that no attacker must gain; empty if the
  /// attacker has gained nothing.
  std::function<std::string()> loot{};
};

/// The facts that an act knows about the programs that it attacks.
struct Target {
  uid_t account = 0;  ///< the account that runs the honest programs and their daemon
  Random random{};
};

enum class Attacker : std::uint8_t {
  other_account,  ///< an account without rights on the publisher's host
  owner,          ///< the account of the honest programs, which harms them by mistake
  neighbour,      ///< root on another host of the network
};

/// The harm of an act to honest programs that SFT cannot prevent.
enum class Harm : std::uint8_t {
  none,    ///< no harm: all pairs are served
  floods,  ///< the act takes so much network or CPU time that samples might not arrive
  /// The act sends messages in the names of honest programs, which cannot be distinguished from genuine
  /// ones. Samples might not arrive, unless the honest programs have certificates.
  forges,
  stops_near,  ///< the act stops the subscriber on the publisher's host
  /// The act leaves files that only the attacker's account or root can remove. Until then a pair may be
  /// served by UDP instead of shared memory, if the status names one of these files.
  leaves_files
};

struct Entry {
  std::string_view name;
  std::string_view sentence;  ///< says what the attacker does
  Attacker attacker;
  Harm harm;
  Act (*make)(Target& target);
};

/// Returns all acts ordered by their subjects: files, shared memory, accidents, control topics, datagrams.
std::span<const Entry> acts();
/// Returns the act with that name; null if there is no such act.
const Entry* find_act(std::string_view name);

}  // namespace sft::hostile
