// Writes to the log sink of a node's program: lines from one level on, and never more than a few lines of one
// kind in a row, so that neither a peer nor a fault that comes again and again can flood it. Lines that are
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

 private:
  Time next_{};  ///< when the budget is whole again, less (burst - 1) periods
  std::uint64_t left_out_ = 0;
};

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
  static constexpr std::size_t event_kinds = static_cast<std::size_t>(Event::Kind::request_changed) + 1;
  static constexpr std::size_t log_levels = static_cast<std::size_t>(LogLevel::error) + 1;
  bool write(LineBudget& budget, LogLevel level, const std::string& text, Time now);
  void write_loss(const std::string& pair, const Event& event, Time now);

  /// Losses of a reliable pair.
  struct Losses {
    Time next_line{};          ///< no line before
    std::uint64_t untold = 0;  ///< samples
  };
  static constexpr std::chrono::seconds loss_pause{1};
  const std::string node_;
  const LogLevel threshold_;
  const NodeOptions::LogSink sink_;
  std::array<LineBudget, event_kinds> of_events_;
  std::array<LineBudget, log_levels> of_node_;
  std::map<std::string, Losses> losses_;  ///< by the name of the pair; pairs that lost something lately
};

}  // namespace sft::core
