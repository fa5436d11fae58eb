// The user data of a node's DDS participant. They say that the participant is a node's, of this version of
// the control topics, and about whose words it complains. Cyclone tells everybody at once when they change,
// by other means than the control topics, so they get through where those are disturbed. discovery.md has the
// rules. The functions are pure.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/discovery/participants.h"

namespace sft::core {

struct ParticipantMark {
  unsigned greeting = 0;    ///< from 0 to 9: without another purpose than to make a change
  bool is_secured = false;  ///< by DDS Security: it does not speak with those that are not
  /// Participants of which something else came here than what they say of themselves.
  std::vector<Participants::Guid> complaints{};

  friend bool operator==(const ParticipantMark&, const ParticipantMark&) = default;
};

inline constexpr std::size_t complaints_max = 8;

/// "sft/11/3", then "s" if it is secured, and for each complaint "!" and 32 hexadecimal digits.
std::string to_text(const ParticipantMark& mark);
/// Empty if it is no node's of this version. Complaints that make no sense are left out.
std::optional<ParticipantMark> parse_participant_mark(std::string_view user_data);
/// The version of the control topics if it is a node's of another one. Marks of all versions begin with
/// "sft/", the version and "/".
std::optional<std::uint32_t> other_version(std::string_view user_data);

}  // namespace sft::core
