// Limits the bytes that may be under way to a remote socket to what the path carries without a queue that
// delays other traffic. Uses no clock, thread or I/O.
//
// The window shrinks if a queue grows long or many datagrams are lost, but at most once for what was sent
// before it shrank. A queue does not make it smaller than what the path takes without a long queue, because
// a report may also be late for another reason. The window grows only while it limits what is sent. It is
// never smaller than FlowLimits::least_bytes.
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

  /// Notes that the window limited what was sent up to `position`: at least half of it was under way.
  void was_full(std::uint64_t position) { full_at_ = position; }
  /// Shrinks so that our own queue is short for a moment, which shows the shortest round trip.
  void make_queue_short();

  /// The facts by which hear() judges a report.
  struct Known {
    bool counted = false;  ///< another report of this path came before
    std::chrono::steady_clock::duration queueing{};
    std::uint64_t reported = 0;  ///< position of the previous report
    std::uint64_t sent = 0;      ///< position up to which datagrams were sent by now
    std::size_t share = 0;       ///< our share of the receiver's buffer
    std::size_t taken = 0;       ///< bytes taken at the best recent rate before a queue counts as long
  };
  void hear(const FlowReport& report, const Known& known);
  /// Begins again for another path.
  void begin_anew();

 private:
  bool lost_much(const FlowReport& report) const;

  FlowLimits limits_;
  std::size_t bytes_ = limits_.first_bytes;
  std::uint64_t full_at_ = 0;    ///< position where at least half of the window was under way last
  std::uint64_t turned_at_ = 0;  ///< position where the window shrank last
  std::uint32_t datagrams_at_report_ = 0;
  std::uint32_t came_at_report_ = 0;
};

}  // namespace sft::udp
