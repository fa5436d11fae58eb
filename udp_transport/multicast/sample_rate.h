// How many samples a writer sends in a second. It is pure: counts and times go in.
#pragma once

#include <chrono>
#include <cstdint>
#include <utility>

namespace sft::udp {

class SampleRate {
 public:
  using Time = std::chrono::steady_clock::time_point;
  /// Samples are counted for so long at least.
  static constexpr std::chrono::milliseconds counting{100};

  explicit SampleRate(Time now) : since_(now) {}

  /// `samples` were sent in all until now. What was counted before is the rate until there is more to count.
  /// The first samples count at once, although there may be more of them than it seems.
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
  /// When there will be more to count, if the last call of count() came too early.
  Time due(Time otherwise) const { return is_early_ ? since_ + counting : otherwise; }

 private:
  Time since_;
  std::uint64_t counted_ = 0;
  double per_s_ = 0;
  bool is_early_ = false;
};

}  // namespace sft::udp
