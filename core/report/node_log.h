// Writes to the log sink of a node's program: lines from one level on, and never more than a few lines of one
// kind about one topic in a row, so that neither a peer nor a fault that comes again and again can flood it.
// A warning that says the same as before, but for its numbers, waits for a pause that grows. Lines that are
// omitted are counted, and the next line of their kind tells how many.
//
// Used by the agent's thread only, so that no lock is needed and none is held. Other threads post to it.
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

/// Lines that may be written: so many at once, then one for each period. Pure.
class LineBudget {
 public:
  static constexpr int burst = 10;
  static constexpr std::chrono::seconds period{5};

  /// True if a line may be written now; if not, it is counted.
  bool take(Time now);
  /// Lines that were not written since the last that was; forgets them.
  std::uint64_t take_left_out();
  /// Nothing was taken lately, and no line waits to be counted.
  bool is_whole(Time now) const { return left_out_ == 0 && next_ <= now - (burst - 1) * period; }

 private:
  Time next_{};  ///< when the budget is whole again, less (burst - 1) periods
  std::uint64_t left_out_ = 0;
};

/// Pauses between lines that say the same: each is twice as long as the one before, unless the line did not
/// come for the longest pause. Pure.
class RepeatPause {
 public:
  static constexpr std::chrono::seconds first{5}, longest{640};

  bool is_over(Time now) const { return now >= next_; }
  void begin(Time now);
  /// The next pause is the first one again.
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

/// Names a topic and, of a subscriber with several selections, which one a line is about.
std::string text_of_topic(std::string_view topic, std::size_t selection);

class NodeLog {
 public:
  NodeLog(std::string node, LogLevel threshold, NodeOptions::LogSink sink);

  bool wants(LogLevel level) const { return sink_ && level >= threshold_; }
  /// Writes what the node itself does, or cannot do.
  void write(LogLevel level, const std::string& text, Time now = std::chrono::steady_clock::now());
  /// Writes what happened to a pair, or to one of our publishers or subscribers. That is a warning if it will
  /// never work as it is set up, or if a promise was broken: a deadline was missed, or samples were lost that
  /// should come reliably. A pair has at most one line about losses in a second. Changes of requests are
  /// frequent, and are for debugging.
  void write(const std::string& topic, const Event& event, Time now = std::chrono::steady_clock::now());
  static LogLevel level_of(const Event& event);
  /// Writes losses of reliable pairs that were not written yet, once their time has come. Called now and
  /// then.
  void tick(Time now);

 private:
  static constexpr std::size_t log_levels = static_cast<std::size_t>(LogLevel::error) + 1;
  /// Further topics and warnings share the budgets of all that are not known.
  static constexpr std::size_t topics_max = 256, repeats_max = 256;
  using TopicBudgets = std::map<Event::Kind, LineBudget>;

  LineBudget& budget_of(const std::string& topic, Event::Kind kind);
  RepeatPause* pause_of(const std::string& text);
  bool write(LineBudget& budget, RepeatPause* pause, LogLevel level, const std::string& text, Time now);
  void write_loss(const std::string& topic, const std::string& pair, const Event& event, Time now);

  /// Losses of a reliable pair.
  struct Losses {
    std::string topic;
    Time next_line{};              ///< no line before
    std::chrono::seconds pause{};  ///< between the last two lines
    std::uint64_t untold = 0;      ///< samples that no message has named yet
    void begin_pause(Time now);
  };
  const std::string node_;
  const LogLevel threshold_;
  const NodeOptions::LogSink sink_;
  std::map<std::string, TopicBudgets> of_topics_;
  TopicBudgets of_other_topics_;
  std::array<LineBudget, log_levels> of_node_;
  std::map<std::string, RepeatPause> pauses_;  ///< of warnings, by their text without numbers
  std::map<std::string, Losses> losses_;       ///< by the name of the pair; pairs that lost something lately
};

}  // namespace sft::core
