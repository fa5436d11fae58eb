// Limits of the reader's end of a channel (ArrivalWindow), for each writer.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

namespace sft::udp {

struct ArrivalLimits {
  std::size_t samples = 4096;                          ///< from the first missing one on
  std::size_t held_bytes = std::size_t{64} << 20;      ///< of whole samples behind one that is missing
  std::size_t awaited_bytes = std::size_t{128} << 20;  ///< of those that readers have no room for
  std::size_t ack_bytes = std::size_t{1} << 20;        ///< so many are acknowledged unasked
  std::chrono::milliseconds ask_after{2};              ///< something was noticed to be missing; at the least
  std::chrono::milliseconds ask_again_longest{250};
  /// A sample that has begun is given up, and begun anew, if neither it nor the first missing one gets any
  /// further for so long, although the writer is heard: what began it may not have been true.
  std::chrono::milliseconds confirm_timeout{300};
  std::chrono::seconds forget_after{5};  ///< without a word from the writer nothing is asked for any more
  std::chrono::milliseconds spread{8};   ///< of what many may miss: later by up to so much, at random
  std::uint32_t seed = 1;                ///< of that
};

}  // namespace sft::udp
