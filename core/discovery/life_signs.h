// The pace of the signs of life that nodes give each other.
#pragma once

#include <chrono>

#include "core/control/control.h"

namespace sft::core {

/// The pace at which a node says that it lives, and the time without such a sign after which it is lost: six
/// in a row may get lost. If ten nodes lose a fifth of all packets, one is then lost falsely every ten
/// minutes or so, and returns with the next sign. Where all is calm (sign_pace.h) twice the pause will do, or
/// a little more: two signs in a row that get lost end the calm.
struct LifeSigns {
  std::chrono::milliseconds pause;
  std::chrono::milliseconds pause_in_calm;  ///< shorter than silence_in(lease)
  std::chrono::milliseconds lease;
};
/// Where signs in calm are pulses (pulse.h), which are heard at the next look (tick_pace.h).
inline constexpr LifeSigns life_signs_by_pulses{std::chrono::milliseconds(650),
                                                std::chrono::milliseconds(932), lease_default};
/// So often at least a sign goes by Cyclone, too. Cyclone's lease covers three of them, and tells others that
/// there are pulses.
inline constexpr std::chrono::milliseconds full_sign_pause{18'640}, full_sign_lease{60'000};
constexpr bool gives_pulses(std::chrono::milliseconds lease_of_signs) {
  return lease_of_signs == full_sign_lease;
}
/// Where there are no pulses.
inline constexpr LifeSigns life_signs_to_all{std::chrono::milliseconds(650), std::chrono::milliseconds(1400),
                                             lease_default};
/// Without multicast, where each node has to be told by itself.
inline constexpr LifeSigns life_signs_to_each{
    std::chrono::milliseconds(1950), std::chrono::milliseconds(3900), std::chrono::milliseconds(14'000)};

}  // namespace sft::core
