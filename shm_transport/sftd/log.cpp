#include "shm_transport/sftd/log.h"

#include <syslog.h>

#include <algorithm>
#include <cstdio>
#include <iterator>

namespace sft::shm {

std::optional<LogLevel> log_level_of(std::string_view name) {
  constexpr std::string_view names[] = {"error", "warning", "info", "debug"};
  const auto found = std::ranges::find(names, name);
  if (found == std::end(names)) return std::nullopt;
  return static_cast<LogLevel>(found - std::begin(names));
}

Log::Log(LogLevel most_detailed, Target target) : most_detailed_(most_detailed), target_(target) {
  if (target_ == Target::system_log) openlog("sftd", LOG_PID, LOG_DAEMON);
}

void Log::write(LogLevel level, const std::string& text) const {
  if (level > most_detailed_) return;
  if (target_ == Target::standard_error) {
    std::fprintf(stderr, "sftd: %s\n", text.c_str());
    return;
  }
  constexpr int priorities[] = {LOG_ERR, LOG_WARNING, LOG_INFO, LOG_DEBUG};
  syslog(priorities[static_cast<int>(level)], "%s", text.c_str());
}

}  // namespace sft::shm
