// The action for which the sending thread has to be woken after a job was given to a lane or a channel, or
// after an answer came.
#pragma once

#include <algorithm>
#include <cstdint>

namespace sft::udp {

/// The values are ordered: each action includes the previous ones.
enum class Wake : std::uint8_t {
  none,
  look,      ///< the thread has to check the lanes and channels in its list (Sender::look_again())
  schedule,  ///< the lane, channel or work has to be added to the thread's list (Sender::schedule())
};

inline Wake strongest(Wake a, Wake b) { return std::max(a, b); }

}  // namespace sft::udp
