// Limits the bytes that may be under way to a remote socket to what the path carries without a queue that
// delays other traffic. Uses no clock, thread or I/O.
//
// The window shrinks if a queue grows long or many datagrams are lost. It shrinks only once for the
// datagrams that were sent before. Because of a queue alone, the window never shrinks below what the path
// takes without a long queue, because a report may also be late for another reason. The window grows only
// while it limits what is sent. It is never smaller than FlowLimits::least_bytes.
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

  /// Notes that the window limited the sending up to `position`: at least half of the window was under way.
  void was_full(std::uint64_t position) { full_at_ = position; }
  /// Shrinks the window, so that our own queue is short for a moment. A short queue shows the shortest
  /// round trip.
  void make_queue_short();

  /// The facts that hear() needs to judge a report.
  struct Known {
    bool counted = false;  ///< true if another report of this path came before
    std::chrono::steady_clock::duration queueing{};
    std::uint64_t reported = 0;  ///< position of the previous report
    std::uint64_t sent = 0;      ///< position up to which datagrams were sent by now
    std::size_t share = 0;       ///< our share of the receiver's buffer, in bytes
    /// Bytes that the receiver takes, at its best recent rate, before a queue counts as long.
    std::size_t taken = 0;
  };
  void hear(const FlowReport& report, const Known& known);
  /// Begins again, because the path is another one.
  void begin_anew();

 private:
  bool lost_much(const FlowReport& report) const;

  FlowLimits limits_;
  std::size_t bytes_ = limits_.first_bytes;
  std::uint64_t full_at_ = 0;    ///< position at which at least half of the window was last under way
  std::uint64_t turned_at_ = 0;  ///< position at which the window last shrank
  std::uint32_t datagrams_at_report_ = 0;
  std::uint32_t came_at_report_ = 0;
};

}  // namespace sft::udp
