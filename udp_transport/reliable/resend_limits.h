// Limits of the writer's end of a channel (ResendWindow).
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

namespace sft::udp {

struct ResendLimits {
  /// Limit of kept samples; if it is exceeded, the oldest one is given up.
  std::size_t samples = 4096;
  std::size_t bytes = std::size_t{64} << 20;  ///< limit of the memory of kept samples, except the newest
  /// Rate limit of repairs; live samples have the rest of the rate.
  std::uint64_t repair_bytes_per_s = 100'000'000;
  std::chrono::milliseconds heartbeat_delay{20};    ///< pause from the last sample to the heartbeat
  std::chrono::milliseconds heartbeat_pause{2000};  ///< average pause between heartbeats while acks arrive
  /// Pause between heartbeats while samples come at their usual rate.
  std::chrono::milliseconds heartbeat_period{4000};
  /// Number of heartbeats that may follow each other faster.
  int heartbeats_saved = 4;
  /// After a lost part, the link counts as bad for this time.
  std::chrono::seconds mistrust{10};
  std::chrono::milliseconds heartbeat_longest{1000};  ///< longest pause between unanswered heartbeats
};

}  // namespace sft::udp
