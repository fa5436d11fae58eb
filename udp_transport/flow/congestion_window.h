// Limits the bytes that may be under way to a remote socket to what the path carries without a queue that
// delays other traffic. Uses no clock, thread or I/O.
//
// The window shrinks if a queue grows long or many datagrams are lost. After it has shrunk, reports about
// datagrams that were sent before do not shrink it again. A long queue alone never shrinks the window below
// what the path carries without a long queue. The reason is that a report may also be late for another
// cause. The window grows only while it limits what is sent. It is never smaller than
// FlowLimits::least_bytes.
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

  /// Notes that at least half of the window was under way when `position` was sent. Only reports up to the
  /// latest such position let the window grow.
  void was_full(std::uint64_t position) { full_at_ = position; }
  /// Shrinks the window, so that the queue of our datagrams on the path is short for a moment. Then the
  /// shortest round trip can be measured.
  void make_queue_short();

  /// The facts, in addition to the report, from which hear() decides.
  struct Known {
    bool counted = false;  ///< true if an earlier report about this path has come
    std::chrono::steady_clock::duration queueing{};
    std::uint64_t reported = 0;  ///< position of the previous report
    std::uint64_t sent = 0;      ///< position of the last sent byte
    std::size_t share = 0;       ///< our share of the receiver's buffer, in bytes
    /// The number of bytes that the receiver takes at its best recent rate during the shortest round trip
    /// plus the tolerated queueing.
    std::size_t taken = 0;
  };
  void hear(const FlowReport& report, const Known& known);
  /// Resets the window. Called when the path has changed.
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
