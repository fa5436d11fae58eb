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

std::uint64_t RepeatPause::take_left_out() { return std::exchange(left_out_, 0); }

void RepeatPause::begin(Time now) {
  pause_ = is_forgotten(now) ? first : std::clamp(2 * pause_, first, longest);
  next_ = now + pause_;
}

std::string without_numbers(std::string_view text) {
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  const auto is_of_word = [&](char c) {  // does not depend on the program's locale
    return is_digit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
  };
  std::string rest;
  bool is_quoted = false;
  for (const char c : text) {
    const bool is_in_word = !rest.empty() && is_of_word(rest.back());
    if (c == '\'') is_quoted = !is_quoted && !is_in_word;  // within a word the character is an apostrophe
    if (!is_digit(c) || is_quoted || is_in_word) rest.push_back(c);
  }
  return rest;
}

std::string text_of_topic(std::string_view topic, std::size_t selection) {
  const std::string text = "topic '" + std::string(topic) + "'";
  return selection == 0 ? text : text + ", selection " + std::to_string(selection);
}

NodeLog::NodeLog(std::string node, LogLevel threshold, NodeOptions::LogSink sink)
    : node_(std::move(node)), threshold_(threshold), sink_(std::move(sink)) {}

void NodeLog::write(LogLevel level, const std::string& text, Time now) {
  if (!wants(level)) return;
  RepeatPause* const pause = level >= LogLevel::warning ? pause_of(text) : nullptr;
  write(of_node_[static_cast<std::size_t>(level)], pause, level, text, now);
}

void NodeLog::write(const std::string& topic, const Event& event, Time now) {
  const LogLevel level = level_of(event);
  if (!wants(level)) return;
  std::string text = text_of_topic(topic, event.selection);
  if (!event.node.empty()) text += ", node '" + event.node + "'";
  if (event.kind == Event::Kind::samples_lost && event.reliable) return write_loss(topic, text, event, now);
  if (!event.text.starts_with(to_string(event.kind))) text += std::string(": ") + to_string(event.kind);
  text += ": " + event.text;
  RepeatPause* const pause = level >= LogLevel::warning ? pause_of(text) : nullptr;
  write(budget_of(topic, event.kind), pause, level, text, now);
}

LineBudget& NodeLog::budget_of(const std::string& topic, Event::Kind kind) {
  const bool is_known = of_topics_.size() < topics_max || of_topics_.contains(topic);
  return (is_known ? of_topics_[topic] : of_other_topics_)[kind];
}

/// Returns the pauses of a warning, or null if too many warnings are tracked already.
RepeatPause* NodeLog::pause_of(const std::string& text) {
  const std::string key = without_numbers(text);
  if (pauses_.size() >= repeats_max && !pauses_.contains(key)) return nullptr;
  return &pauses_[key];
}

/// Writes a line about losses. If the line must not be written now, its losses are added to the next line
/// about the same pair.
void NodeLog::write_loss(const std::string& topic, const std::string& pair, const Event& event, Time now) {
  const auto [known, is_new] = losses_.try_emplace(pair + ", publisher " + in_hex(event.peer), Losses{topic});
  Losses& losses = known->second;
  LineBudget& budget = budget_of(topic, Event::Kind::samples_lost);
  const std::string before =
      losses.untold == 0 ? "" : " (" + std::to_string(losses.untold) + " more were lost before that)";
  if (now < losses.next_line ||
      !write(budget, nullptr, LogLevel::warning, pair + ": samples lost: " + event.text + before, now)) {
    losses.untold += event.count;
    return;
  }
  losses.untold = 0;
  losses.begin_pause(now);
}

void NodeLog::Losses::begin_pause(Time now) {
  pause = std::clamp(2 * pause, std::chrono::seconds(1), std::chrono::seconds(64));
  next_line = now + pause;
}

void NodeLog::tick(Time now) {
  for (auto& [pair, losses] : losses_) {
    if (now < losses.next_line || losses.untold == 0) continue;
    const std::string text = pair + ": samples lost: " + std::to_string(losses.untold) +
                             " more were lost although reliability was requested";
    if (write(budget_of(losses.topic, Event::Kind::samples_lost), nullptr, LogLevel::warning, text, now))
      losses.untold = 0;
    losses.begin_pause(now);
  }
  std::erase_if(losses_,
                [now](const auto& item) { return item.second.untold == 0 && item.second.next_line <= now; });
  std::erase_if(pauses_, [now](const auto& item) { return item.second.is_forgotten(now); });
  std::erase_if(of_topics_, [now](const auto& item) {
    return std::ranges::all_of(item.second, [now](const auto& one) { return one.second.is_whole(now); });
  });
}

/// Writes a line unless the level, the pause or the budget forbids it. Returns true if the line was written.
bool NodeLog::write(LineBudget& budget, RepeatPause* pause, LogLevel level, const std::string& text,
                    Time now) {
  if (!wants(level)) return false;
  if (pause != nullptr && !pause->is_over(now)) {
    pause->leave_out();
    return false;
  }
  if (!budget.take(now)) return false;
  std::uint64_t left_out = budget.take_left_out();
  if (pause != nullptr) {
    left_out += pause->take_left_out();
    pause->begin(now);
  }
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
    case Event::Kind::samples_diverted:
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
      return LogLevel::info;
  }
  return LogLevel::info;
}

}  // namespace sft::core
