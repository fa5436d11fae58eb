// The end of a channel: once it has no reader any more it lingers, so that the last samples are repaired, and
// then it is closed. A channel that is closed sends nothing. Pure.
#pragma once

#include <algorithm>
#include <chrono>
#include <optional>

namespace sft::udp {

class ChannelLife {
 public:
  using Time = std::chrono::steady_clock::time_point;
  /// After the last reader has gone, samples are repaired for so long.
  static constexpr std::chrono::seconds linger{2};

  /// No reader is behind the channel any more. Only the first call counts.
  void end(Time now) {
    if (!ended_at_) ended_at_ = now;
  }
  void close() { is_closed_ = true; }

  bool is_closed() const { return is_closed_; }
  /// True if no reader waits for what is published now.
  bool has_ended() const { return is_closed_ || ended_at_; }
  bool has_lingered(Time now) const { return ended_at_ && now - *ended_at_ > linger; }
  /// The time to look again: `otherwise`, or sooner if the channel has lingered by then.
  Time next_look(Time otherwise) const {
    return ended_at_ ? std::min(otherwise, *ended_at_ + linger + std::chrono::milliseconds(1)) : otherwise;
  }

 private:
  bool is_closed_ = false;
  std::optional<Time> ended_at_;
};

}  // namespace sft::udp
