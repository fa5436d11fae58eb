// The action that the sending thread has to be woken for, after a job was given to a lane or a channel, or
// an answer came.
#pragma once

#include <algorithm>
#include <cstdint>

namespace sft::udp {

/// The values are ordered: each includes the previous ones.
enum class Wake : std::uint8_t {
  none,
  look,      ///< the thread has to check the lanes and channels that it knows (Sender::look_again())
  schedule,  ///< the thread does not know this lane, channel or work yet (Sender::schedule())
};

inline Wake strongest(Wake a, Wake b) { return std::max(a, b); }

}  // namespace sft::udp
