// The phases of a run. A phase is an event at the remote reader, during which the readers on the
// publisher's host are observed.
#pragma once

#include <array>
#include <string>

namespace sft::bench::isolation {

enum class Phase {
  alone,    ///< there is no remote reader: the baseline
  again,    ///< the same as `alone`; the difference between the two is noise
  joined,   ///< the remote reader starts at the beginning of the phase, and reads everything from then on
  stalled,  ///< the remote reader's process is stopped
  lossy,    ///< the remote reader loses a fifth of the packets that are sent to it
  narrow,   ///< the remote reader requests all fields over a link of 50 Mbit/s
  killed    ///< the remote reader's process is killed
};

inline constexpr std::array all_phases{Phase::alone, Phase::again,  Phase::joined, Phase::stalled,
                                       Phase::lossy, Phase::narrow, Phase::killed};
inline constexpr std::array disturbances{Phase::joined, Phase::stalled, Phase::lossy, Phase::narrow,
                                         Phase::killed};

/// Returns the name in tables and figures, such as "joined".
inline std::string name_of(Phase phase) {
  constexpr std::array names{"alone", "again", "joined", "stalled", "lossy", "narrow", "killed"};
  return names[static_cast<std::size_t>(phase)];
}

}  // namespace sft::bench::isolation
