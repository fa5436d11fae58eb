// Measures which ports use how much of the memory. It also notes the peak of each port, because iceoryx only
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

/// One thread at a time uses it. That thread keeps ports from being created or destroyed meanwhile.
class UsageMonitor {
 public:
  /// All arguments outlive this object.
  UsageMonitor(iox::roudi::PortPool& ports, const iox::mepoo::MemoryManager& pools,
               std::span<const std::byte> management)
      : ports_(ports), pools_(pools), holdings_(management, pools) {}

  /// Returns the current usage by pools, publishers and subscribers.
  Usage look();

 private:
  using Peaks = std::map<std::uint64_t, std::uint32_t>;  ///< of ports, by iceoryx's id
  void note_peak(const iox::popo::BasePortData& port, Holding& held, Peaks& peaks) const;
  void look_at_pools(Usage& usage) const;

  iox::roudi::PortPool& ports_;
  const iox::mepoo::MemoryManager& pools_;
  const ChunkHoldings holdings_;
  Peaks peaks_;
};

}  // namespace sft::shm
