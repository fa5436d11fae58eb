// The latest round trip to a remote socket, and the shortest recent one. Uses no clock, thread or I/O.
#pragma once

#include <algorithm>
#include <chrono>

namespace sft::udp {

class RoundTrips {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Duration = Time::duration;

  /// The shortest round trip is replaced after this time, because routes change.
  static constexpr std::chrono::seconds shortest_valid_for{10};

  /// `unheard` counts as the latest round trip until a round trip is noted.
  explicit RoundTrips(Duration unheard) : unheard_(unheard) {}

  /// Notes a round trip. Returns true if the shortest round trip was too old and was replaced by this one.
  bool note(Duration time, Time now) {
    latest_ = time;
    const bool begins_anew = now - shortest_since_ > shortest_valid_for;
    if (begins_anew) {
      shortest_ = time;
      shortest_since_ = now;
    }
    shortest_ = std::min(shortest_, time);
    return begins_anew;
  }
  /// Resets the estimates for another path.
  void forget() {
    latest_ = unheard_;
    shortest_ = Duration::max();
  }

  Duration latest() const { return latest_; }
  /// Returns the shortest recent round trip; Duration::max() if none is known.
  Duration shortest() const { return shortest_; }
  /// Returns the time that the latest datagram waited in queues.
  Duration queueing() const { return latest_ - shortest_; }

 private:
  Duration unheard_;
  Duration latest_ = unheard_;
  Duration shortest_ = Duration::max();
  Time shortest_since_{};
};

}  // namespace sft::udp
