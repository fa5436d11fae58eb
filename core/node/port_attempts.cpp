#include "core/node/port_attempts.h"

namespace sft::core {

/// Notes the outcome in `retry`. Returns true if the outcome is the first failure with its reason.
bool PortAttempts::is_new_failure(Retry& retry, const Result<void>& outcome) {
  if (!outcome) return retry.failed(outcome.error().message, std::chrono::steady_clock::now());
  retry.succeeded();
  return false;
}

bool PortAttempts::over_network(Retry& retry, const Open& open) {
  if (!retry.due(std::chrono::steady_clock::now())) return false;
  const Result<void> opened = open();
  if (is_new_failure(retry, opened)) log_.write(LogLevel::warning, opened.error().message);
  return opened.has_value();
}

bool PortAttempts::in_memory(Retry& retry, const Open& open) {
  const Time now = std::chrono::steady_clock::now();
  if (!retry.due(now)) return false;
  if (!asking_daemon_.due(now)) {
    retry.hold_with(asking_daemon_);  // without this, the attempt would not be repeated
    return false;
  }
  const Result<void> opened = open();
  if (!opened && memory_ != nullptr && memory_->awaits_answer()) {
    retry.hold(now, opened.error().message);
    return false;
  }
  const bool answered = opened || opened.error().code != Errc::unavailable;
  const bool is_news = is_new_failure(retry, opened);
  if (answered) asking_daemon_.succeeded();
  if ((answered || is_new_failure(asking_daemon_, opened)) && is_news)
    log_.write(LogLevel::warning, opened.error().message);
  return opened.has_value();
}

}  // namespace sft::core
