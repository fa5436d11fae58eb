// A token bucket: a burst, then a steady rate. Uses no clock, thread or I/O.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>

namespace sft::udp {

class Pacer {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// A rate of 0 means that neither the rate nor bursts are limited. A burst has at least one byte.
  Pacer(std::uint64_t bytes_per_s, std::size_t burst_bytes)
      : bytes_per_s_(static_cast<double>(bytes_per_s)),
        burst_(static_cast<double>(std::max<std::size_t>(burst_bytes, 1))),
        quantum_(std::min(burst_ / 8, quantum_max)) {}

  /// Returns true if one more batch may be sent, because the bucket has more than `reserve` bytes, which are
  /// kept for other senders. The batch may be larger than the rest of the bucket. Then the next batch waits
  /// until the bucket has refilled.
  bool ready(Time now, std::size_t reserve = 0) {
    refill(now);
    return bytes_per_s_ == 0 || tokens_ > static_cast<double>(reserve);
  }
  void spend(std::size_t bytes) { tokens_ -= static_cast<double>(bytes); }

  /// Returns the time at which sending may continue if nothing is spent before. At that time the bucket has
  /// tokens for a few system calls, so that the caller does not wake for a few bytes.
  Time next_ready(Time now, std::size_t reserve = 0) const {
    const double missing = static_cast<double>(reserve) - tokens_;
    if (bytes_per_s_ == 0 || missing < 0) return now;
    return now +
           std::chrono::nanoseconds(static_cast<std::int64_t>((quantum_ + missing) / bytes_per_s_ * 1e9));
  }

 private:
  static constexpr double quantum_max = 192 * 1024;  // the number of bytes of three system calls

  void refill(Time now) {
    const std::chrono::duration<double> since = now - last_;
    tokens_ = std::min(burst_, tokens_ + since.count() * bytes_per_s_);
    last_ = now;
  }

  const double bytes_per_s_;
  const double burst_;
  const double quantum_;
  double tokens_ = 0;
  Time last_{};  ///< initially long ago, so that the first refill fills the bucket
};

}  // namespace sft::udp
