#include "core/report/log_setting.h"

#include <unistd.h>

#include <algorithm>
#include <iterator>
#include <string_view>

namespace sft::core {

namespace {

constexpr std::string_view names[] = {"debug", "info", "warning", "error"};  // in the order of LogLevel

/// Writes a line with one system call, so that lines of several processes do not mix. Errors are ignored,
/// since there is no other place to report them.
void write_to_standard_error(LogLevel level, std::string_view text) {
  std::string line = "[sft] " + std::string(names[static_cast<std::size_t>(level)]) + ": ";
  line.append(text).push_back('\n');
  [[maybe_unused]] const ssize_t written = ::write(STDERR_FILENO, line.data(), line.size());
}

}  // namespace

LogSetting log_setting(const NodeOptions& options, const char* environment) {
  if (options.log) return {.sink = options.log, .threshold = options.log_level.value_or(LogLevel::info)};
  LogSetting setting{.sink = &write_to_standard_error,
                     .threshold = options.log_level.value_or(LogLevel::warning)};
  const std::string_view wanted = environment == nullptr ? "" : environment;
  if (wanted == "off") return {};
  const auto* const named = std::ranges::find(names, wanted);
  if (named != std::end(names)) {
    setting.threshold = static_cast<LogLevel>(named - std::begin(names));
  } else if (!wanted.empty()) {
    setting.complaint = "the environment variable SFT_LOG is '" + std::string(wanted) +
                        "', which is none of off, error, warning, info and debug; the log begins at " +
                        std::string(names[static_cast<std::size_t>(setting.threshold)]);
  }
  return setting;
}

}  // namespace sft::core
