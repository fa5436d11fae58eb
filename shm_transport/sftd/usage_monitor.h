// Measures how much of the memory each port uses. It also notes the peak of each port, because iceoryx only
// notes the peaks of pools.
#pragma once

#include <cstdint>
#include <map>

#include "shm_transport/sftd/chunk_holdings.h"
#include "shm_transport/sftd/status.h"

namespace iox::roudi {
class PortPool;
}

namespace sft::shm {

/// An object must be used by only one thread at a time. During a call that thread must keep ports from being
/// created or destroyed.
class UsageMonitor {
 public:
  /// All arguments must outlive this object.
  UsageMonitor(iox::roudi::PortPool& ports, const iox::mepoo::MemoryManager& pools,
               std::span<const std::byte> management)
      : ports_(ports), pools_(pools), holdings_(management, pools) {}

  /// Returns the current usage by pools, publishers and subscribers.
  Usage look();

 private:
  /// The maximum number of chunks that each port has held, by iceoryx's id of the port.
  using Peaks = std::map<std::uint64_t, std::uint32_t>;
  void note_peak(const iox::popo::BasePortData& port, Holding& held, Peaks& peaks) const;
  void look_at_pools(Usage& usage) const;

  iox::roudi::PortPool& ports_;
  const iox::mepoo::MemoryManager& pools_;
  const ChunkHoldings holdings_;
  Peaks peaks_;
};

}  // namespace sft::shm
