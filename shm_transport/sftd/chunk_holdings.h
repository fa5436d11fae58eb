// Counts the chunks that a port holds. The owner of the port takes and gives back chunks during the count.
// So the code here does not rely on consistent data, and follows no pointer in shared memory without a
// check.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "shm_transport/host/iceoryx.h"
#include "shm_transport/sftd/status.h"

namespace sft::shm {

/// Any thread may call the functions.
class ChunkHoldings {
 public:
  /// `management` is the management segment as it is mapped in this process. It must outlive this object.
  /// `pools` are the pools of the segment of samples.
  ChunkHoldings(std::span<const std::byte> management, const iox::mepoo::MemoryManager& pools);

  /// Returns the chunks that the port holds now. The result has no peak, because finding a peak takes
  /// several calls.
  Holding of(const iox::popo::SubscriberPortData& port) const;
  /// Returns the chunks that the writer holds now. `keeper` is the port whose list has the chunks of the
  /// writer (writer_port.h); it may be null.
  Holding of(const iox::popo::PublisherPortData& port, const iox::popo::SubscriberPortData* keeper) const;

 private:
  using Chunk = iox::mepoo::ShmSafeUnmanagedChunk;
  struct PoolRange {
    /// The end of the pool in the segment of samples, in which the pools follow each other.
    std::uint64_t end = 0;
    std::uint64_t chunk_bytes = 0;
  };
  std::uint64_t bytes_of(const Chunk& chunk) const;
  Holding sum_of(std::span<const Chunk> chunks) const;

  std::span<const std::byte> management_;
  std::vector<PoolRange> pools_;
};

}  // namespace sft::shm
