#include "core/report/node_log.h"

#include <algorithm>
#include <utility>

#include "core/platform/random_id.h"

namespace sft::core {

bool LineBudget::take(Time now) {
  next_ = std::max(next_, now - (burst - 1) * period);
  if (next_ > now) {
    ++left_out_;
    return false;
  }
  next_ += period;
  return true;
}

std::uint64_t LineBudget::take_left_out() { return std::exchange(left_out_, 0); }

std::string text_of_topic(std::string_view topic, std::size_t selection) {
  const std::string text = "topic '" + std::string(topic) + "'";
  return selection == 0 ? text : text + ", selection " + std::to_string(selection);
}

NodeLog::NodeLog(std::string node, LogLevel threshold, NodeOptions::LogSink sink)
    : node_(std::move(node)), threshold_(threshold), sink_(std::move(sink)) {}

void NodeLog::write(LogLevel level, const std::string& text, Time now) {
  write(of_node_[static_cast<std::size_t>(level)], level, text, now);
}

void NodeLog::write(const std::string& topic, const Event& event, Time now) {
  const LogLevel level = level_of(event);
  if (!wants(level)) return;
  std::string text = text_of_topic(topic, event.selection);
  if (!event.node.empty()) text += ", node '" + event.node + "'";
  if (event.kind == Event::Kind::samples_lost && event.reliable) return write_loss(text, event, now);
  if (!event.text.starts_with(to_string(event.kind))) text += std::string(": ") + to_string(event.kind);
  write(of_events_[static_cast<std::size_t>(event.kind)], level, text + ": " + event.text, now);
}

/// Losses that are not written now are added to the next line of the pair.
void NodeLog::write_loss(const std::string& pair, const Event& event, Time now) {
  const auto [known, is_new] = losses_.try_emplace(pair + ", publisher " + in_hex(event.peer));
  Losses& losses = known->second;
  LineBudget& budget = of_events_[static_cast<std::size_t>(Event::Kind::samples_lost)];
  const std::string before =
      losses.untold == 0 ? "" : " (" + std::to_string(losses.untold) + " more were lost before that)";
  if (now < losses.next_line ||
      !write(budget, LogLevel::warning, pair + ": samples lost: " + event.text + before, now)) {
    losses.untold += event.count;
    return;
  }
  losses = {.next_line = now + loss_pause};
}

void NodeLog::tick(Time now) {
  for (auto& [pair, losses] : losses_) {
    if (now < losses.next_line || losses.untold == 0) continue;
    const std::string text = pair + ": samples lost: " + std::to_string(losses.untold) +
                             " more were lost although reliability was requested";
    if (write(of_events_[static_cast<std::size_t>(Event::Kind::samples_lost)], LogLevel::warning, text, now))
      losses.untold = 0;
    losses.next_line = now + loss_pause;
  }
  std::erase_if(losses_,
                [now](const auto& item) { return item.second.untold == 0 && item.second.next_line <= now; });
}

/// True if the line was written.
bool NodeLog::write(LineBudget& budget, LogLevel level, const std::string& text, Time now) {
  if (!wants(level) || !budget.take(now)) return false;
  const std::uint64_t left_out = budget.take_left_out();
  sink_(level, node_ + ": " + text +
                   (left_out == 0 ? "" : " (" + std::to_string(left_out) + " similar lines were left out)"));
  return true;
}

LogLevel NodeLog::level_of(const Event& event) {
  switch (event.kind) {
    case Event::Kind::incompatible_qos:
    case Event::Kind::incompatible_type:
    case Event::Kind::held_too_many:
    case Event::Kind::deadline_missed:
      return LogLevel::warning;
    case Event::Kind::samples_lost:
      return event.reliable ? LogLevel::warning : LogLevel::info;
    case Event::Kind::no_path:
      return event.yet ? LogLevel::info : LogLevel::warning;
    case Event::Kind::request_changed:
      return LogLevel::debug;
    case Event::Kind::matched:
    case Event::Kind::unmatched:
    case Event::Kind::path_changed:
    case Event::Kind::liveliness_lost:
    case Event::Kind::liveliness_recovered:
    case Event::Kind::samples_diverted:
      return LogLevel::info;
  }
  return LogLevel::info;
}

}  // namespace sft::core
