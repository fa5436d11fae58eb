// The times there and back on the way to a remote socket: the latest, and the shortest of late. Pure.
#pragma once

#include <algorithm>
#include <chrono>

namespace sft::udp {

class RoundTrips {
 public:
  using Time = std::chrono::steady_clock::time_point;
  using Duration = Time::duration;

  /// Routes change: a shortest time holds for so long.
  static constexpr std::chrono::seconds shortest_valid_for{10};

  /// `unheard` is taken for the latest time until one is noted.
  explicit RoundTrips(Duration unheard) : unheard_(unheard) {}

  /// Notes a time. Returns true if the shortest one was too old; from now on another one counts.
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
  /// The way is another one.
  void forget() {
    latest_ = unheard_;
    shortest_ = Duration::max();
  }

  Duration latest() const { return latest_; }
  Duration shortest() const { return shortest_; }  ///< Duration::max(): not known
  /// The time that the latest datagram stood in queues.
  Duration queueing() const { return latest_ - shortest_; }

 private:
  Duration unheard_;
  Duration latest_ = unheard_;
  Duration shortest_ = Duration::max();
  Time shortest_since_{};
};

}  // namespace sft::udp
