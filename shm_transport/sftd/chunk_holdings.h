// Which chunks a port holds, read while its owner takes and gives back others: nothing here relies on what it
// reads being whole, and no pointer in shared memory is followed unchecked.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "shm_transport/host/iceoryx.h"
#include "shm_transport/sftd/status.h"

namespace sft::shm {

/// Any thread.
class ChunkHoldings {
 public:
  /// `management`: that segment in this process; outlives this. `pools`: those of the segment of samples.
  ChunkHoldings(std::span<const std::byte> management, const iox::mepoo::MemoryManager& pools);

  /// Without the peak, which takes more than one look.
  Holding of(const iox::popo::SubscriberPortData& port) const;
  /// `keeper`: the port that the writer keeps its chunks in (writer_port.h); may be null.
  Holding of(const iox::popo::PublisherPortData& port, const iox::popo::SubscriberPortData* keeper) const;

 private:
  using Chunk = iox::mepoo::ShmSafeUnmanagedChunk;
  struct PoolRange {
    std::uint64_t end = 0;  ///< in the segment of samples; the pools lie there one after the other
    std::uint64_t chunk_bytes = 0;
  };
  std::uint64_t bytes_of(const Chunk& chunk) const;
  Holding sum_of(std::span<const Chunk> chunks) const;

  std::span<const std::byte> management_;
  std::vector<PoolRange> pools_;
};

}  // namespace sft::shm
