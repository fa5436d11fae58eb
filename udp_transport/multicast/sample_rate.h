// The number of samples that a writer sends per second, and the number of samples per second that pass a
// gate (core::Gate). Both classes use no clock, thread or I/O.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <utility>

namespace sft::udp {

class SampleRate {
 public:
  using Time = std::chrono::steady_clock::time_point;
  /// The minimum time over which samples are counted.
  static constexpr std::chrono::milliseconds counting{100};

  /// `samples` is the number of samples sent before `now`.
  explicit SampleRate(Time now, std::uint64_t samples = 0) : since_(now), counted_(samples) {}

  /// Updates the rate; `samples` is the number of samples sent so far. The former rate is valid until
  /// `counting` has passed. A first rate is set at once, although it may be too low.
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
  /// Returns the time at which count() can update the rate, if its last call came too early. Otherwise
  /// returns `otherwise`.
  Time due(Time otherwise) const { return is_early_ ? since_ + counting : otherwise; }

 private:
  Time since_;
  std::uint64_t counted_;
  double per_s_ = 0;
  bool is_early_ = false;
};

/// The rate of samples that pass a gate. It is measured over a longer time, because such samples may come in
/// bursts, and a multicast group is useful only if they come steadily.
class PassRate {
 public:
  using Time = SampleRate::Time;
  /// The minimum time over which samples are counted, as soon as this time has passed.
  static constexpr std::chrono::seconds counting{5};

  /// `passed` is the number of samples that have passed so far. The next passing sample is not counted,
  /// because the first sample after a request always passes.
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
