// Limits of the writer's end of a channel (ResendWindow).
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

namespace sft::udp {

struct ResendLimits {
  std::size_t samples = 4096;                         ///< kept; beyond that the oldest goes
  std::size_t bytes = std::size_t{64} << 20;          ///< of memory that these hold, but for the newest
  std::uint64_t repair_bytes_per_s = 100'000'000;     ///< live samples have the rest
  std::chrono::milliseconds heartbeat_delay{20};      ///< after the last sample
  std::chrono::milliseconds heartbeat_pause{2000};    ///< average pause between heartbeats while acks arrive
  std::chrono::milliseconds heartbeat_period{4000};   ///< while samples come as usual
  int heartbeats_saved = 4;                           ///< that may follow each other faster
  std::chrono::seconds mistrust{10};                  ///< of a link, after it has lost something
  std::chrono::milliseconds heartbeat_longest{1000};  ///< between two that were not
};

}  // namespace sft::udp
