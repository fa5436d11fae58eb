// Commands that measure and print a line per second: their options and their loop.
#pragma once

#include <cstddef>
#include <functional>

#include "tools/sft/session.h"

namespace sft::tool {

/// The indentation of text that does not fit into the line of its topic.
inline constexpr std::size_t live_indent = 4;

struct LiveOptions {
  double for_s = 0;     ///< the duration in seconds; 0: the command runs until the user stops it
  double window_s = 5;  ///< each line covers this time, in seconds
};

/// Calls `report` once a second, until options.for_s seconds have passed or the user wants to stop.
void report_every_second(const LiveOptions& options, Stop& stop, const std::function<void()>& report);

}  // namespace sft::tool
