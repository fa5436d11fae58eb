// How many samples a writer sends per second, and how many of them pass a gate. Both classes use no clock,
// thread or I/O.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <utility>

namespace sft::udp {

class SampleRate {
 public:
  using Time = std::chrono::steady_clock::time_point;
  /// Samples are counted for at least this time.
  static constexpr std::chrono::milliseconds counting{100};

  /// `samples` is the number of samples sent before.
  explicit SampleRate(Time now, std::uint64_t samples = 0) : since_(now), counted_(samples) {}

  /// Updates the rate; `samples` is the number of samples sent so far. The former rate holds until
  /// `counting` is over. The first samples count at once, although their rate may be higher than it seems
  /// then.
  void count(std::uint64_t samples, Time now) {
    is_early_ = now - since_ < counting;
    if (is_early_ && per_s_ > 0) return;
    const std::chrono::duration<double> seconds = is_early_ ? counting : now - since_;
    per_s_ = static_cast<double>(samples - counted_) / seconds.count();
    if (is_early_) return;
    since_ = now;
    counted_ = samples;
  }
  double per_s() const { return per_s_; }
  /// Returns when the next rate is ready, if the last call of count() came too early; else `otherwise`.
  Time due(Time otherwise) const { return is_early_ ? since_ + counting : otherwise; }

 private:
  Time since_;
  std::uint64_t counted_;
  double per_s_ = 0;
  bool is_early_ = false;
};

/// Counts for a longer time, because samples may pass in bursts, and a group is useful only if they come
/// steadily.
class PassRate {
 public:
  using Time = SampleRate::Time;
  /// Least time that samples are counted, once it has passed.
  static constexpr std::chrono::seconds counting{5};

  /// The next sample that passes does not count, because it is the first one after a request.
  PassRate(Time now, std::uint64_t passed) : former_{now, passed + 1}, latest_(former_) {}

  /// Returns the rate. `passed` is the number of samples that have passed so far.
  double per_s(Time now, std::uint64_t passed) {
    if (now - latest_.at >= counting) former_ = std::exchange(latest_, Count{now, passed});
    const std::chrono::duration<double> seconds =
        std::max<SampleRate::Time::duration>(now - former_.at, SampleRate::counting);
    return passed <= former_.passed ? 0 : static_cast<double>(passed - former_.passed) / seconds.count();
  }

 private:
  struct Count {
    Time at;
    std::uint64_t passed;
  };
  Count former_, latest_;
};

}  // namespace sft::udp
