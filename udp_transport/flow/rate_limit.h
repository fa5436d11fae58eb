// Limits the bytes per second that a writer or a whole transport may send, in all threads together.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>

#include "core/sync/mutex.h"
#include "udp_transport/flow/pacer.h"

namespace sft::udp {

/// Small samples may be sent as long as any tokens are left. Large samples leave a quarter of a burst for
/// small samples. Any thread may call the functions.
class RateLimit {
 public:
  using Time = Pacer::Time;

  /// `bytes_per_s` 0: there is no limit.
  explicit RateLimit(std::uint64_t bytes_per_s)
      : limited_(bytes_per_s != 0),
        batch_(limited_ ? static_cast<std::size_t>(bytes_per_s / 500) : SIZE_MAX),
        reserve_(burst_for(bytes_per_s) / 4),
        pacer_(bytes_per_s, burst_for(bytes_per_s)) {}

  bool ready(bool small, Time now) {
    if (!limited_) return true;
    const core::Lock lock(mutex_);
    return pacer_.ready(now, small ? 0 : reserve_);
  }
  void spend(std::size_t bytes) {
    if (!limited_) return;
    const core::Lock lock(mutex_);
    pacer_.spend(bytes);
  }
  /// Returns the maximum number of bytes of a large sample that are sent at a time. So small samples wait no
  /// longer than these bytes take.
  std::size_t batch_bytes() const { return batch_; }
  /// Returns the time at which ready() should be called again if nothing is spent before.
  Time next_ready(bool small, Time now) {
    if (!limited_) return now;
    const core::Lock lock(mutex_);
    return pacer_.next_ready(now, small ? 0 : reserve_);
  }

 private:
  /// Returns the size of a burst in bytes: that of a train of datagrams, or that of the data of 10 ms if
  /// that is more.
  static std::size_t burst_for(std::uint64_t bytes_per_s) {
    return static_cast<std::size_t>(std::max<std::uint64_t>(64 * 1024, bytes_per_s / 100));
  }

  const bool limited_;
  const std::size_t batch_;
  const std::size_t reserve_;
  core::Mutex mutex_;
  Pacer pacer_ SFT_GUARDED_BY(mutex_);
};

}  // namespace sft::udp
