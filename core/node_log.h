// What a node says to its program's log sink: from a level on, and of one kind never more than a few lines in
// a row, so that neither a peer nor a fault that comes again and again can flood it. What was left out is
// counted, and said with the next line of its kind.
//
// The agent's thread, so that no lock is needed and none is held. Other threads post to it.
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "sft/event.h"
#include "sft/options.h"

namespace sft::core {

/// Lines that may be written: so many at once, then one for each period. Pure.
class LineBudget {
 public:
  using Now = std::chrono::steady_clock::time_point;
  static constexpr int burst = 10;
  static constexpr std::chrono::seconds period{5};

  /// Whether a line may be written now; if not, it is counted.
  bool take(Now now);
  /// Lines that were not written since the last that was; forgets them.
  std::uint64_t take_left_out();

 private:
  Now next_{};  ///< when the budget is whole again, less (burst - 1) periods
  std::uint64_t left_out_ = 0;
};

class NodeLog {
 public:
  using Now = LineBudget::Now;
  NodeLog(std::string node, LogLevel threshold, LogSink sink);

  bool wants(LogLevel level) const { return sink_ && level >= threshold_; }
  /// Something that the node does or cannot do itself.
  void write(LogLevel level, const std::string& text, Now now = std::chrono::steady_clock::now());
  /// What happened to a pair, or to one of our publishers or subscribers. A warning if it will never work as
  /// it is set up; what a program asks for changes often, and is for debugging.
  void write(const std::string& topic, const Event& event, Now now = std::chrono::steady_clock::now());
  static LogLevel level_of(const Event& event);

 private:
  static constexpr std::size_t event_kinds = static_cast<std::size_t>(EventKind::request_changed) + 1;
  static constexpr std::size_t log_levels = static_cast<std::size_t>(LogLevel::error) + 1;
  void write(LineBudget& budget, LogLevel level, const std::string& text, Now now);

  const std::string node_;
  const LogLevel threshold_;
  const LogSink sink_;
  std::array<LineBudget, event_kinds> of_events_;
  std::array<LineBudget, log_levels> of_node_;
};

}  // namespace sft::core
