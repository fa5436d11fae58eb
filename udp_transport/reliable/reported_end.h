// The end of a channel as heartbeats tell it, where that contradicts what has come. Pure.
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

  /// The channel is followed from that ordinal on.
  void begin(std::uint64_t ordinal) { new_from_ = ordinal; }
  void go_back_to(std::uint64_t ordinal) { new_from_ = std::min(new_from_, ordinal); }
  /// True if the heartbeat tells of a sample that is followed.
  bool is_news(const Heartbeat& heartbeat) const {
    return heartbeat.end != heartbeat.first && heartbeat.end > new_from_;
  }

  /// Nothing contradicts the writer, or something new came.
  void agrees() { end_ = 0; }
  /// The writer says that it has published nothing from that ordinal on, but something of that came. Returns
  /// true if it has said the same for OrdinalMonitor::unconfirmed_after.
  bool insists_on(std::uint64_t end, Time now) {
    if (std::exchange(end_, end) == end) return now - since_ >= OrdinalMonitor::unconfirmed_after;
    since_ = now;
    return false;
  }

 private:
  std::uint64_t new_from_ = 0;  ///< what heartbeats say of ordinals before this one is no news
  std::uint64_t end_ = 0;       ///< as it is said, less than what has come; 0: it is not
  Time since_{};
};

}  // namespace sft::udp
