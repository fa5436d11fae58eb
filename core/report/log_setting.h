// Determines where the lines of a node's log are written, and the minimum level of these lines. The lines
// are passed to the sink of the program. Without a sink, warnings and errors are written to the standard
// error; the environment variable SFT_LOG may set another level.
#pragma once

#include <string>

#include "sft/options.h"

namespace sft::core {

struct LogSetting {
  NodeOptions::LogSink sink{};  ///< empty: there is no log
  LogLevel threshold = LogLevel::warning;
  std::string complaint{};  ///< the fault in the value of SFT_LOG, to be logged as a warning; empty: no fault
};

/// Returns the setting of a node. `environment` is the value of SFT_LOG, or null.
LogSetting log_setting(const NodeOptions& options, const char* environment);

}  // namespace sft::core
