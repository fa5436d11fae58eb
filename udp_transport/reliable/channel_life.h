// The last phase of a channel. A channel without readers continues for a while, so that lost parts of its
// last samples are sent again. Then it is closed. A closed channel sends nothing. Uses no clock, thread or
// I/O.
#pragma once

#include <algorithm>
#include <chrono>
#include <optional>

namespace sft::udp {

class ChannelLife {
 public:
  using Time = std::chrono::steady_clock::time_point;
  /// Lost parts of samples are sent again for this time after the last reader has gone.
  static constexpr std::chrono::seconds linger{2};

  /// Notes that the channel has no reader any more. Only the first call counts.
  void end(Time now) {
    if (!ended_at_) ended_at_ = now;
  }
  void close() { is_closed_ = true; }

  bool is_closed() const { return is_closed_; }
  /// Returns true if no reader needs the samples that are published now.
  bool has_ended() const { return is_closed_ || ended_at_; }
  bool has_lingered(Time now) const { return ended_at_ && now - *ended_at_ > linger; }
  /// Returns the time of the next check: `otherwise`, or the end of the time `linger` if that is earlier.
  Time next_look(Time otherwise) const {
    return ended_at_ ? std::min(otherwise, *ended_at_ + linger + std::chrono::milliseconds(1)) : otherwise;
  }

 private:
  bool is_closed_ = false;
  std::optional<Time> ended_at_;
};

}  // namespace sft::udp
