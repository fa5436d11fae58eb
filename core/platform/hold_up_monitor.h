// Reports delays of a thread that should wait only for its own events. The thread marks the beginning of
// each piece of its work. A piece that took too long is reported with its place in the source. A piece of
// work may also take long because the thread got no processor meanwhile.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <source_location>

#include "core/platform/clock.h"

namespace sft::core {

/// A monitor must be used by only one thread.
class HoldUpMonitor {
 public:
  using Report = std::function<void(std::source_location what, std::chrono::milliseconds held_up)>;
  static constexpr std::chrono::milliseconds held_up_max{50};

  /// If `report` is empty, the monitor does nothing.
  explicit HoldUpMonitor(Report report, ReadTime time = &std::chrono::steady_clock::now);
  ~HoldUpMonitor();
  HoldUpMonitor(const HoldUpMonitor&) = delete;
  HoldUpMonitor& operator=(const HoldUpMonitor&) = delete;

  /// Begins a piece of work, and ends the previous piece.
  void begin(std::source_location what);
  void end();

 private:
  const Report report_;
  const ReadTime time_;
  struct Piece {
    std::source_location what;
    Time since;
  };
  std::optional<Piece> piece_;
};

/// Marks that the calling thread begins another piece of its work. Does nothing on threads without a monitor.
void next_piece_of_work(std::source_location what = std::source_location::current());

}  // namespace sft::core
