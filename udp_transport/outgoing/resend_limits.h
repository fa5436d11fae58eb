// The limits and times of the writer's end of a channel (ResendWindow).
#pragma once

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <cstdint>

namespace sft::udp {

struct ResendLimits {
  /// The maximum number of kept samples; if more come, the oldest ones are given up.
  std::size_t samples = 4096;
  std::size_t bytes = std::size_t{64} << 20;  ///< maximum memory of kept samples, without `samples_least`
  /// These newest samples are kept even if they exceed `bytes`.
  std::size_t samples_least = 1;
  /// The maximum rate of repairs, so that the rest of the rate is left for new samples.
  std::uint64_t repair_bytes_per_s = 100'000'000;
  std::chrono::milliseconds heartbeat_delay{20};    ///< pause from the last sample to the heartbeat
  std::chrono::milliseconds heartbeat_pause{2000};  ///< average pause between heartbeats while acks arrive
  /// The pause between heartbeats while samples are sent at their usual rate.
  std::chrono::milliseconds heartbeat_period{4000};
  /// The maximum number of heartbeats that may follow each other without that average pause.
  int heartbeats_saved = 4;
  /// For this time after a loss, the link counts as bad, so that heartbeats come sooner.
  std::chrono::seconds mistrust{10};
  std::chrono::milliseconds heartbeat_longest{1000};  ///< longest pause between unanswered heartbeats

  /// Returns the limits of a writer whose samples may take `most` bytes. A sample that is given up while it
  /// is being sent has cost the link its bytes for nothing. So a small limit does not hold for large samples
  /// that follow each other.
  static ResendLimits of_at_most(std::size_t most) {
    ResendLimits limits;
    if (most < limits.bytes) limits.samples_least = 3;
    limits.bytes = std::min(limits.bytes, most);
    return limits;
  }
};

}  // namespace sft::udp
