#include "shm_transport/host/chunk_pools.h"

namespace sft::shm {

std::optional<ChunkPools::Choice> ChunkPools::choose(std::size_t bytes) const noexcept {
  constexpr int candidates = 2;
  std::size_t payload = payload_for(bytes);
  int tried = 0;
  for (std::uint32_t i = 0; i < pools_.getNumberOfMemPools() && tried < candidates; ++i) {
    const auto pool = pools_.getMemPoolInfo(i);
    if (pool.m_chunkSize < payload + chunk_header_size) continue;
    if (pool.m_usedChunks + vanished_[i].count() < pool.m_numChunks) {
      return Choice{i, static_cast<std::uint32_t>(payload)};
    }
    payload = pool.m_chunkSize - chunk_header_size + 8;  // this size makes iceoryx take a larger pool
    ++tried;
  }
  return std::nullopt;
}

std::size_t ChunkPools::largest_bytes() const noexcept {
  const std::uint32_t pools = pools_.getNumberOfMemPools();
  return pools == 0 ? 0 : pools_.getMemPoolInfo(pools - 1).m_chunkSize - chunk_header_size;
}

void ChunkPools::note_empty(const Choice& choice) noexcept {
  const auto pool = pools_.getMemPoolInfo(choice.pool);
  if (pool.m_usedChunks >= pool.m_numChunks) return;  // other writers have taken the last chunks meanwhile
  Vanished& vanished = vanished_[choice.pool];
  vanished.chunks.store(pool.m_numChunks - pool.m_usedChunks, std::memory_order_relaxed);
  vanished.until.store(Clock::now() + std::chrono::seconds(1), std::memory_order_relaxed);
}

std::uint32_t ChunkPools::Vanished::count() const noexcept {
  const std::uint32_t noted = chunks.load(std::memory_order_relaxed);
  return noted == 0 || Clock::now() >= until.load(std::memory_order_relaxed) ? 0 : noted;
}

}  // namespace sft::shm
