// Determines the destination of the lines of a node's log, and their lowest level. The lines go to the sink
// of the program. Without a sink, warnings and errors go to the standard error, unless the environment
// variable SFT_LOG names another level.
#pragma once

#include <string>

#include "sft/options.h"

namespace sft::core {

struct LogSetting {
  NodeOptions::LogSink sink{};  ///< empty: there is no log
  LogLevel threshold = LogLevel::warning;
  std::string complaint{};  ///< the fault of SFT_LOG, to be logged as a warning; empty: no fault
};

/// Returns the setting of a node. `environment` is the value of SFT_LOG, or null.
LogSetting log_setting(const NodeOptions& options, const char* environment);

}  // namespace sft::core
