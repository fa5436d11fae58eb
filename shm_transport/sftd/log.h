// Writes the messages of sftd: to the terminal if it runs in the foreground, otherwise to syslog.
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <utility>

namespace sft::shm {

enum class LogLevel { error, warning, info, debug };

std::optional<LogLevel> log_level_of(std::string_view name);

class Log {
 public:
  enum class Target { standard_error, system_log };
  Log(LogLevel most_detailed, Target target);

  /// Writes a message. Any thread may call this.
  void write(LogLevel level, const std::string& text) const;
  void warning(const std::string& text) const { write(LogLevel::warning, text); }
  void info(const std::string& text) const { write(LogLevel::info, text); }
  void debug(const std::string& text) const { write(LogLevel::debug, text); }

 private:
  LogLevel most_detailed_;
  Target target_;
};

}  // namespace sft::shm
