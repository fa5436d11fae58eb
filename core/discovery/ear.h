// An ear: what was heard of one speaker, for hearing_watch.h.
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <set>

#include "core/control/control.h"
#include "core/platform/clock.h"

namespace sft::core {

struct Ear {
  Time last;  ///< when anything of the participant, or the participant itself, came last
  bool has_spoken = false;
  bool has_agreed = false;
  int unmatched = 0;  ///< endpoints that were withdrawn and did not come back
  Time unmatched_at{};
  NodeId node = 0;           ///< the one of the speaker that was heard last; it may be made up
  std::set<NodeId> nodes{};  ///< those that were heard while both digests were equal, and live
  std::set<NodeId> named{};  ///< those that full signs of life have named, and live; some may be made up
  bool lives = false;        ///< signs of life came, and Cyclone did not tell that they ended
  Time last_life{};
  Time last_full{};  ///< when the last sign of life came by Cyclone
  std::optional<Time> last_pulse{};
  /// The number of full signs that the speaker had given when the last one came. Nothing until a pulse tells.
  std::optional<std::uint8_t> full_signs{};
  std::uint8_t full_signs_missed = 0;  ///< so many have been given since, by the last pulse
  std::chrono::milliseconds lease{};
  std::uint32_t told = 0;    ///< the digest that the signs of life tell
  Time told_at{};            ///< that was so at that time, or later
  std::uint32_t known = 0;   ///< the digest of what was known at the last look
  std::uint32_t shared = 0;  ///< both digests, when they were equal last
  Time agreed{};             ///< when both were equal, or what is known changed
  Time changed{};            ///< when what is known changed
  /// True if the signs of life still carry the digest from before the change: somebody else than the
  /// speaker made the change.
  bool is_contradicted = false;
  std::optional<Time> overdue_since{};
  std::optional<Time> missed_since{};
  Time complain_at{};
  std::optional<Time> disbelieved_since{};

  /// A speaker counts as heard for so long after it was. Signs of life come more often.
  static constexpr std::chrono::milliseconds heard_lately{2500};
  /// Announcements and signs of life overtake each other by less than that.
  static constexpr std::chrono::milliseconds overtaking{100};
  /// True if a sign of life came lately, and told of nothing else than what is known.
  bool is_well(Time now) const { return lives && told == known && now - last_life < heard_lately; }
  /// True if the last sign of life told of something else than what was known before it. What came after it
  /// is confirmed by the next one: if each change of a mask made signs frequent everywhere, they would hardly
  /// ever be seldom.
  bool is_told_of_more() const { return lives && told != known && last_life - agreed > overtaking; }
};

}  // namespace sft::core
