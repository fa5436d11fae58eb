// Where the lines of a node's log go, and from which level on: to the sink of the program, or else warnings
// and errors to the standard error, unless the environment variable SFT_LOG says otherwise.
#pragma once

#include <string>

#include "sft/options.h"

namespace sft::core {

struct LogSetting {
  NodeOptions::LogSink sink{};  ///< empty: there is no log
  LogLevel threshold = LogLevel::warning;
  std::string complaint{};  ///< about the environment; not empty: to be logged as a warning
};

/// `environment`: SFT_LOG, which may be null.
LogSetting log_setting(const NodeOptions& options, const char* environment);

}  // namespace sft::core
