// The bytes that may be under way to a remote socket: as many as the way carries without a queue in which
// others have to wait. Pure.
//
// The window shrinks where a queue grows long or much is lost, and at most once for what was sent before. A
// queue does not make it smaller than what the way takes without a long queue: a report that is late for
// another reason says nothing of the window. The window grows only where it was the limit. It is never
// smaller than FlowLimits::least_bytes.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

#include "udp_transport/flow/flow_limits.h"
#include "udp_transport/wire/datagram.h"

namespace sft::udp {

class CongestionWindow {
 public:
  explicit CongestionWindow(const FlowLimits& limits) : limits_(limits) {}

  std::size_t bytes() const { return bytes_; }

  /// The window was the limit for what was sent up to that position: at least half of it was under way.
  void was_full(std::uint64_t position) { full_at_ = position; }
  /// Shrinks so that the own queue is short for a moment, which shows the shortest time there and back.
  void make_queue_short();

  /// The facts by which a report is judged.
  struct Known {
    bool counted = false;  ///< another report of this way came before
    std::chrono::steady_clock::duration queueing{};
    std::uint64_t reported = 0;  ///< the position of the report before
    std::uint64_t sent = 0;      ///< up to now
    std::size_t share = 0;       ///< of the receiver's buffer
    std::size_t taken = 0;       ///< at the best rate of late, while a queue gets long
  };
  void hear(const FlowReport& report, const Known& known);
  /// The way is another one.
  void begin_anew();

 private:
  bool lost_much(const FlowReport& report) const;

  FlowLimits limits_;
  std::size_t bytes_ = limits_.first_bytes;
  std::uint64_t full_at_ = 0;    ///< position where as much as the way carries was under way last
  std::uint64_t turned_at_ = 0;  ///< position where the window was made smaller
  std::uint32_t datagrams_at_report_ = 0;
  std::uint32_t came_at_report_ = 0;
};

}  // namespace sft::udp
