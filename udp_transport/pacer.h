// How fast one destination may be sent to: a burst that its socket
// buffer surely holds, then a steady rate. Pure.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>

namespace sft::udp {

class Pacer {
 public:
  using Time = std::chrono::steady_clock::time_point;

  /// A rate of 0 is no limit, for bursts neither.
  explicit Pacer(std::uint64_t bytes_per_s) : wanted_bytes_per_s_(static_cast<double>(bytes_per_s)) {
    set_burst(0);
  }

  /// At least one byte. May be set again at any time. A small burst lowers the rate too: the buffer that it
  /// stands for also has to hold what comes while the receiver is kept from running.
  void set_burst(std::size_t bytes) {
    burst_ = static_cast<double>(std::max<std::size_t>(bytes, 1));
    bytes_per_s_ = std::min(wanted_bytes_per_s_, burst_ / receiver_pause_s);
    quantum_ = std::min(burst_ / 8, quantum_max);
  }

  /// One more batch may go; it may take more than is left, which is made up for before the next.
  bool ready(Time now) {
    refill(now);
    return wanted_bytes_per_s_ == 0 || tokens_ > 0;
  }
  void spend(std::size_t bytes) { tokens_ -= static_cast<double>(bytes); }
  /// What was spent and then not sent.
  void give_back(std::size_t bytes) { tokens_ += static_cast<double>(bytes); }

  /// When to go on, if nothing is spent until then: once there is enough for more than a moment's work.
  Time next_ready(Time now) const {
    if (wanted_bytes_per_s_ == 0 || tokens_ > 0) return now;
    return now +
           std::chrono::nanoseconds(static_cast<std::int64_t>((quantum_ - tokens_) / bytes_per_s_ * 1e9));
  }

 private:
  static constexpr double receiver_pause_s = 0.002;
  static constexpr double quantum_max = 192 * 1024;  // three calls' worth

  void refill(Time now) {
    const std::chrono::duration<double> since = now - last_;
    tokens_ = std::min(burst_, tokens_ + since.count() * bytes_per_s_);
    last_ = now;
  }

  const double wanted_bytes_per_s_;
  double bytes_per_s_ = 0;
  double burst_ = 0;
  double quantum_ = 0;
  double tokens_ = 0;
  Time last_{};  ///< long ago: the first refill is a full one
};

}  // namespace sft::udp
