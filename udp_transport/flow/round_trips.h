// The latest round trip to a remote socket, and the shortest recent one. Uses no clock, thread or I/O.
#pragma once

#include <algorithm>
#include <chrono>

namespace sft::udp {

class RoundTrips {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Duration = Time::duration;

  /// A shortest round trip counts only for this time, because routes change.
  static constexpr std::chrono::seconds shortest_valid_for{10};

  /// `unheard` is returned as the latest round trip until one is noted.
  explicit RoundTrips(Duration unheard) : unheard_(unheard) {}

  /// Notes a round trip. Returns true if the shortest one was too old; then this one replaces it.
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
  /// Begins again for another path.
  void forget() {
    latest_ = unheard_;
    shortest_ = Duration::max();
  }

  Duration latest() const { return latest_; }
  /// The shortest recent round trip; Duration::max(): not known.
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
