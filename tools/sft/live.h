// The options of what is measured and told once a second, and the loop of it.
#pragma once

#include <cstddef>
#include <functional>

#include "tools/sft/session.h"

namespace sft::tool {

/// Of what does not fit the line of a topic.
inline constexpr std::size_t live_indent = 4;

struct LiveOptions {
  double for_s = 0;     ///< 0: until it is stopped
  double window_s = 5;  ///< what is told is about so long
};

/// Calls `tell` once a second, until that is over or the user wants to stop.
void tell_every_second(const LiveOptions& options, Stop& stop, const std::function<void()>& tell);

}  // namespace sft::tool
