// Who uses how much of the memory, looked at again and again: iceoryx keeps the peak of each pool, and none
// of a single port.
#pragma once

#include <cstdint>
#include <map>

#include "shm_transport/sftd/chunk_holdings.h"
#include "shm_transport/sftd/status.h"

namespace iox::roudi {
class PortPool;
}

namespace sft::shm {

/// Used by one thread at a time, which keeps ports from being created or destroyed meanwhile.
class UsageBook {
 public:
  /// All outlive this.
  UsageBook(iox::roudi::PortPool& ports, const iox::mepoo::MemoryManager& pools,
            std::span<const std::byte> management)
      : ports_(ports), pools_(pools), holdings_(management, pools) {}

  /// Pools, publishers and subscribers as they are now.
  Usage look();

 private:
  using Peaks = std::map<std::uint64_t, std::uint32_t>;  ///< by iceoryx's id of a port
  void note_peak(const iox::popo::BasePortData& port, Holding& held, Peaks& peaks) const;
  void look_at_pools(Usage& usage) const;

  iox::roudi::PortPool& ports_;
  const iox::mepoo::MemoryManager& pools_;
  const ChunkHoldings holdings_;
  Peaks peaks_;
};

}  // namespace sft::shm
