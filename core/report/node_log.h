// Writes the lines that have at least the configured level to the log sink of a node's program. It limits
// the number of lines of one kind about one topic, so that neither a peer nor a repeated fault can flood
// the log. A warning that differs from an earlier warning only in numbers is not written again before a
// pause is over. The pause grows with each repetition. Lines that are left out are counted, and the next
// line of their kind contains their number.
//
// Used by the agent's thread only, so that no lock is needed. Other threads post to that thread.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>

#include "core/platform/clock.h"
#include "sft/event.h"
#include "sft/options.h"

namespace sft::core {

/// Limits lines: `burst` lines may be written at once, and then one line per period. It uses no clock:
/// times are passed in, decisions are returned.
class LineBudget {
 public:
  static constexpr int burst = 10;
  static constexpr std::chrono::seconds period{5};

  /// Returns true if a line may be written now. If it must not be written, the line counts as left out.
  bool take(Time now);
  /// Returns the number of lines that were left out since the last call.
  std::uint64_t take_left_out();
  /// Returns true if `burst` lines may be written now, and no lines were left out.
  bool is_whole(Time now) const { return left_out_ == 0 && next_ <= now - (burst - 1) * period; }

 private:
  Time next_{};  ///< the time at which a whole burst is allowed again, minus (burst - 1) periods
  std::uint64_t left_out_ = 0;
};

/// The pauses between equal lines. Each pause is twice as long as the previous one. If the line has not
/// occurred for the longest pause, the pauses start again with the first one. The class uses no clock:
/// times are passed in, decisions are returned.
class RepeatPause {
 public:
  static constexpr std::chrono::seconds first{5}, longest{640};

  bool is_over(Time now) const { return now >= next_; }
  void begin(Time now);
  /// Returns true if the line has not occurred for so long that its pauses start again with the first one.
  bool is_forgotten(Time now) const { return now >= next_ + longest; }
  void leave_out() { ++left_out_; }
  std::uint64_t take_left_out();

 private:
  Time next_{};
  std::chrono::seconds pause_{0};
  std::uint64_t left_out_ = 0;
};

/// Returns the text without the numbers in it, except for those in names and quotation marks.
std::string without_numbers(std::string_view text);

/// Returns a text that names a topic and, if a subscriber has several selections, the selection.
std::string text_of_topic(std::string_view topic, std::size_t selection);

class NodeLog {
 public:
  NodeLog(std::string node, LogLevel threshold, NodeOptions::LogSink sink);

  bool wants(LogLevel level) const { return sink_ && level >= threshold_; }
  /// Writes a line about the node itself.
  void write(LogLevel level, const std::string& text, Time now = std::chrono::steady_clock::now());
  /// Writes an event of a pair, or of one of the node's publishers or subscribers. The event is a warning
  /// if the pair can never work as it is configured, if a deadline was missed, or if a reliable pair lost
  /// samples. The losses of a pair are written at most once per second. Changes of requests are frequent,
  /// and have the level `debug`.
  void write(const std::string& topic, const Event& event, Time now = std::chrono::steady_clock::now());
  static LogLevel level_of(const Event& event);
  /// Writes the losses of reliable pairs that were not written yet, if a line may be written now. Must be
  /// called now and then.
  void tick(Time now);

 private:
  static constexpr std::size_t log_levels = static_cast<std::size_t>(LogLevel::error) + 1;
  /// The maximum number of topics with separate budgets, and the maximum number of warnings whose
  /// repetitions are tracked. Further topics share one set of budgets.
  static constexpr std::size_t topics_max = 256, repeats_max = 256;
  using TopicBudgets = std::map<Event::Kind, LineBudget>;

  LineBudget& budget_of(const std::string& topic, Event::Kind kind);
  RepeatPause* pause_of(const std::string& text);
  bool write(LineBudget& budget, RepeatPause* pause, LogLevel level, const std::string& text, Time now);
  void write_loss(const std::string& topic, const std::string& pair, const Event& event, Time now);

  /// Losses of a reliable pair.
  struct Losses {
    std::string topic;
    Time next_line{};              ///< the earliest time of the next line about these losses
    std::chrono::seconds pause{};  ///< the pause between the last two lines
    std::uint64_t untold = 0;      ///< lost samples that no line has reported yet
    void begin_pause(Time now);
  };
  const std::string node_;
  const LogLevel threshold_;
  const NodeOptions::LogSink sink_;
  std::map<std::string, TopicBudgets> of_topics_;
  TopicBudgets of_other_topics_;
  std::array<LineBudget, log_levels> of_node_;
  std::map<std::string, RepeatPause> pauses_;  ///< the pauses of warnings, by their text without numbers
  std::map<std::string, Losses> losses_;       ///< the recent losses, by the name of the pair
};

}  // namespace sft::core
