// Tells what holds a thread up that should wait for nothing but its own events. The thread says when it
// begins another piece of its work, and each piece that took too long is told, with its place in the source.
// A piece may also take long because the system gave the thread no processor meanwhile.
#pragma once

#include <chrono>
#include <functional>
#include <optional>
#include <source_location>

#include "core/platform/clock.h"

namespace sft::core {

/// Used by one thread.
class HoldUpWatch {
 public:
  using Tell = std::function<void(std::source_location what, std::chrono::milliseconds held_up)>;
  static constexpr std::chrono::milliseconds held_up_max{50};

  /// Without `tell` it does nothing.
  explicit HoldUpWatch(Tell tell, ReadTime time = &std::chrono::steady_clock::now);
  ~HoldUpWatch();
  HoldUpWatch(const HoldUpWatch&) = delete;
  HoldUpWatch& operator=(const HoldUpWatch&) = delete;

  /// Ends the piece before.
  void begin(std::source_location what);
  void end();

 private:
  const Tell tell_;
  const ReadTime time_;
  struct Piece {
    std::source_location what;
    Time since;
  };
  std::optional<Piece> piece_;
};

/// From here on the calling thread does another piece of its work. Does nothing on threads that have no
/// watch.
void next_piece_of_work(std::source_location what = std::source_location::current());

}  // namespace sft::core
