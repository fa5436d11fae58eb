// Limits of the writer's end of a channel (ResendWindow).
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

namespace sft::udp {

struct ResendLimits {
  std::size_t samples = 4096;                 ///< most samples kept; beyond that the oldest one is given up
  std::size_t bytes = std::size_t{64} << 20;  ///< most memory of kept samples, except the newest
  std::uint64_t repair_bytes_per_s = 100'000'000;   ///< rate limit of repairs; live samples have the rest
  std::chrono::milliseconds heartbeat_delay{20};    ///< pause from the last sample to the heartbeat
  std::chrono::milliseconds heartbeat_pause{2000};  ///< average pause between heartbeats while acks arrive
  /// Pause between heartbeats while samples come as usual.
  std::chrono::milliseconds heartbeat_period{4000};
  int heartbeats_saved = 4;                           ///< heartbeats that may follow each other faster
  std::chrono::seconds mistrust{10};                  ///< time that a lost part counts for a bad link
  std::chrono::milliseconds heartbeat_longest{1000};  ///< longest pause between unanswered heartbeats
};

}  // namespace sft::udp
