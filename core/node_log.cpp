#include "core/node_log.h"

#include <algorithm>
#include <utility>

namespace sft::core {

bool LineBudget::take(Now now) {
  next_ = std::max(next_, now - (burst - 1) * period);
  if (next_ > now) {
    ++left_out_;
    return false;
  }
  next_ += period;
  return true;
}

std::uint64_t LineBudget::take_left_out() { return std::exchange(left_out_, 0); }

NodeLog::NodeLog(std::string node, LogLevel threshold, LogSink sink)
    : node_(std::move(node)), threshold_(threshold), sink_(std::move(sink)) {}

void NodeLog::write(LogLevel level, const std::string& text, Now now) {
  write(of_node_[static_cast<std::size_t>(level)], level, text, now);
}

void NodeLog::write(const std::string& topic, const Event& event, Now now) {
  const LogLevel level = level_of(event);
  if (!wants(level)) return;
  std::string text = "topic '" + topic + "'";
  if (!event.node.empty()) text += ", node '" + event.node + "'";
  if (!event.text.starts_with(to_string(event.kind))) text += std::string(": ") + to_string(event.kind);
  write(of_events_[static_cast<std::size_t>(event.kind)], level, text + ": " + event.text, now);
}

void NodeLog::write(LineBudget& budget, LogLevel level, const std::string& text, Now now) {
  if (!wants(level) || !budget.take(now)) return;
  const std::uint64_t left_out = budget.take_left_out();
  sink_(level, node_ + ": " + text +
                   (left_out == 0 ? "" : " (" + std::to_string(left_out) + " more of its kind left out)"));
}

LogLevel NodeLog::level_of(const Event& event) {
  switch (event.kind) {
    case EventKind::incompatible_qos:
    case EventKind::incompatible_type:
    case EventKind::held_too_many:
      return LogLevel::warning;
    case EventKind::no_path:
      return event.yet ? LogLevel::info : LogLevel::warning;
    case EventKind::request_changed:
      return LogLevel::debug;
    case EventKind::matched:
    case EventKind::unmatched:
    case EventKind::path_changed:
    case EventKind::deadline_missed:
    case EventKind::liveliness_lost:
    case EventKind::liveliness_recovered:
    case EventKind::samples_lost:
    case EventKind::samples_diverted:
      return LogLevel::info;
  }
  return LogLevel::info;
}

}  // namespace sft::core
