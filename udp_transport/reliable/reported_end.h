// Monitors the end of a channel that the writer's heartbeats report, for the case that it contradicts
// samples that have come. Uses no clock, thread or I/O.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <utility>

#include "udp_transport/reliable/ordinal_monitor.h"
#include "udp_transport/wire/datagram.h"

namespace sft::udp {

class ReportedEnd {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// Begins with a channel that is followed from that ordinal on.
  void begin(std::uint64_t ordinal) { new_from_ = ordinal; }
  void go_back_to(std::uint64_t ordinal) { new_from_ = std::min(new_from_, ordinal); }
  /// Returns true if the heartbeat reports samples, and at least one of them is at or after the first
  /// followed ordinal.
  bool is_news(const Heartbeat& heartbeat) const {
    return heartbeat.end != heartbeat.first && heartbeat.end > new_from_;
  }

  /// Notes that no sample contradicts the writer's heartbeats, or that a new sample came.
  void agrees() { end_ = 0; }
  /// Notes that a heartbeat reports the end `end`, although a sample with that ordinal or a greater one has
  /// come. Returns true if heartbeats have had the same end for OrdinalMonitor::unconfirmed_after.
  bool insists_on(std::uint64_t end, Time now) {
    if (std::exchange(end_, end) == end) return now - since_ >= OrdinalMonitor::unconfirmed_after;
    since_ = now;
    return false;
  }

 private:
  std::uint64_t new_from_ = 0;  ///< heartbeats about ordinals before this one contain nothing new
  std::uint64_t end_ = 0;       ///< reported end that contradicts a sample that has come; 0: none
  Time since_{};
};

}  // namespace sft::udp
