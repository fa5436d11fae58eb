// An ear: what was heard of one speaker, for hearing_watch.h.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <set>

#include "core/control/control.h"
#include "core/discovery/pulse.h"
#include "core/platform/clock.h"

namespace sft::core {

/// The signs of life of a speaker: the full ones, which come by Cyclone, and pulses.
struct SignsHeard {
  std::chrono::milliseconds lease{};  ///< of full signs: Cyclone's
  std::set<NodeId> named{};           ///< by full signs, and live; some may be made up
  std::set<NodeId> announced{};       ///< by endpoints; some may be made up, or not live any more
  Time last_full{};
  std::optional<Time> last_pulse{};
  /// Pulses that have come one after another since the last full sign, whose node no full sign has named.
  struct Unnamed {
    Time first, last;
    std::uint8_t full_given = 0;   ///< the number of full signs that the first of them tells
    std::uint8_t full_missed = 0;  ///< so many have been given since, by the last one
  };
  std::optional<Unnamed> unnamed{};
  /// The number of full signs that the speaker had given when the last one came. Nothing until a pulse tells.
  std::optional<std::uint8_t> full_given{};
  std::uint8_t full_missed = 0;  ///< so many have been given since, by the last pulse
  Time told_at{};                ///< what the last sign tells was so at that time, or later
  std::optional<Time> overdue_since{};

  bool has_full_come() const { return last_full != Time{}; }
  /// True if a pulse of that node counts as a sign of life.
  bool may_live(NodeId node) const { return named.contains(node) || announced.contains(node); }
  void full_sign_came(NodeId node, std::chrono::milliseconds its_lease, Time now);
  /// The pulse has come after `since`.
  void pulse_came(const Pulse& pulse, Time since, Time now);
  void unnamed_pulse_came(const Pulse& pulse, Time now);
  /// True if full signs were given that did not come, as pulses show: frequent ones would help.
  /// `longer`: what newcomers are given takes so much longer in a crowd.
  bool misses_full_sign(std::chrono::milliseconds longer, Time now) const {
    return full_missed > 0 || none_comes_for(full_sign_comes_within + longer, now);
  }
  /// True if none has come although frequent ones were wanted for a while: Cyclone discards them.
  bool hears_no_full_sign(std::chrono::milliseconds longer, Time now) const {
    return none_comes_for(frequent_ones_come_within + longer, now) &&
           unnamed->full_missed >= first_missed_max;
  }

 private:
  /// A newcomer hears a full sign of everybody within that time, unless several have got lost in a row.
  static constexpr std::chrono::milliseconds full_sign_comes_within{2000}, frequent_ones_come_within{4000};
  static constexpr std::uint8_t first_missed_max = 4;

  /// True if pulses have come for longer than that, and still come, without any full sign.
  bool none_comes_for(std::chrono::milliseconds duration, Time now) const;
};

struct Ear {
  Time last;  ///< when anything of the participant, or the participant itself, came last
  bool has_spoken = false;
  bool has_agreed = false;
  int unmatched = 0;  ///< endpoints that were withdrawn and did not come back
  Time unmatched_at{};
  NodeId node = 0;           ///< the one of the speaker that was heard last; it may be made up
  std::set<NodeId> nodes{};  ///< those that were heard while both digests were equal, and live
  bool lives = false;        ///< signs of life came, and Cyclone did not tell that they ended
  Time last_life{};
  SignsHeard signs{};
  std::uint32_t told = 0;    ///< the digest that the signs of life tell
  std::uint32_t known = 0;   ///< the digest of what was known at the last look
  std::uint32_t shared = 0;  ///< both digests, when they were equal last
  Time agreed{};             ///< when both were equal, or what is known changed
  Time changed{};            ///< when what is known changed
  /// True if the signs of life still carry the digest from before the change: somebody else than the
  /// speaker made the change.
  bool is_contradicted = false;
  std::optional<Time> doubtful_since{};
  std::optional<Time> missed_since{};
  Time complain_at{};
  std::optional<Time> disbelieved_since{};

  /// A speaker counts as heard for so long after it was. Signs of life come more often.
  static constexpr std::chrono::milliseconds heard_lately{2500};
  /// Announcements and signs of life overtake each other by less than that.
  static constexpr std::chrono::milliseconds overtaking{100};
  /// The nodes of a speaker that are remembered; more may be made up.
  static constexpr std::size_t nodes_max = 1024;
  /// A sign of life was given after `since`. A pulse may have waited, and then tells what was so before the
  /// latest full sign. Returns true if the digests are equal.
  bool lives_by(NodeId node_of_sign, std::uint32_t digest, Time since, Time now);
  /// True if a sign of life came lately, and told of nothing else than what is known.
  bool is_well(Time now) const { return lives && told == known && now - last_life < heard_lately; }
  /// True if the last sign of life told of something else than what was known before it. What came after it
  /// is confirmed by the next one: if each change of a mask made signs frequent everywhere, they would hardly
  /// ever be seldom.
  bool is_told_of_more() const { return lives && told != known && last_life - agreed > overtaking; }
  /// True if nothing is missing of the speaker, and only its silence could change that.
  bool is_steady() const {
    return lives && told == known && has_agreed && unmatched == 0 && !is_contradicted && !doubtful_since &&
           !missed_since && !disbelieved_since && signs.last_pulse && signs.full_missed == 0 &&
           !signs.unnamed && !signs.overdue_since;
  }
  /// Notes at a look whether the ear is doubtful. Returns true if it has been so for `duration`.
  bool is_doubtful_for(std::chrono::milliseconds duration, bool is_doubtful, Time now);
};

}  // namespace sft::core
