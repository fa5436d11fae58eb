// The log of a node: lines for the log sink of the program, from one level on. Of one kind it writes never
// more than a few lines in a row, so that neither a peer nor a repeated fault can flood the sink. It counts
// the lines that it leaves out, and says their number with the next line of that kind.
//
// Only the agent's thread uses it, so that no lock is needed. Other threads post to that thread.
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

  /// Whether a line may be written now; if not, it is counted.
  bool take(Time now);
  /// Lines that were not written since the last that was; forgets them.
  std::uint64_t take_left_out();

 private:
  Time next_{};  ///< when the budget is whole again, less (burst - 1) periods
  std::uint64_t left_out_ = 0;
};

class NodeLog {
 public:
  NodeLog(std::string node, LogLevel threshold, LogSink sink);

  bool wants(LogLevel level) const { return sink_ && level >= threshold_; }
  /// Something that the node does or cannot do itself.
  void write(LogLevel level, const std::string& text, Time now = std::chrono::steady_clock::now());
  /// What happened to a pair, or to one of our publishers or subscribers. A warning if it will never work as
  /// it is set up, or if a promise was broken: a deadline, or samples that were to come reliably, of which a
  /// pair has at most one line in a second. What a program asks for changes often, and is for debugging.
  void write(const std::string& topic, const Event& event, Time now = std::chrono::steady_clock::now());
  static LogLevel level_of(const Event& event);
  /// Writes what was left out of losses of reliable pairs, once its time has come. Called now and then.
  void tick(Time now);

 private:
  static constexpr std::size_t event_kinds = static_cast<std::size_t>(EventKind::request_changed) + 1;
  static constexpr std::size_t log_levels = static_cast<std::size_t>(LogLevel::error) + 1;
  bool write(LineBudget& budget, LogLevel level, const std::string& text, Time now);
  void write_loss(const std::string& pair, const Event& event, Time now);

  /// The losses of a reliable pair.
  struct Losses {
    Time next_line{};          ///< not before
    std::uint64_t untold = 0;  ///< samples
  };
  static constexpr std::chrono::seconds loss_pause{1};
  const std::string node_;
  const LogLevel threshold_;
  const LogSink sink_;
  std::array<LineBudget, event_kinds> of_events_;
  std::array<LineBudget, log_levels> of_node_;
  std::map<std::string, Losses> losses_;  ///< by what names the pair; those that lost something lately
};

}  // namespace sft::core
