#include "shm_transport/sftd/chunk_holdings.h"

#include <algorithm>
#include <bit>
#include <cstring>

#include <iceoryx_posh/internal/mepoo/chunk_management.hpp>

namespace sft::shm {

using iox::mepoo::ShmSafeUnmanagedChunk;
using iox::popo::PublisherPortData;
using iox::popo::SubscriberPortData;

namespace {

/// The layout of iceoryx's list of chunks in use, whose members are private in iceoryx.
template <std::uint32_t capacity>
struct ListLayout {
  std::atomic_flag synchronizer;
  std::uint32_t used;
  std::uint32_t free;
  std::uint32_t indices[capacity];
  ShmSafeUnmanagedChunk chunks[capacity];
};

template <std::uint32_t capacity>
std::vector<ShmSafeUnmanagedChunk> chunks_in(const iox::popo::UsedChunkList<capacity>& list) {
  using Layout = ListLayout<capacity>;
  static_assert(sizeof(Layout) == sizeof(list) && alignof(Layout) == alignof(decltype(list)));
  std::vector<ShmSafeUnmanagedChunk> chunks;
  for (const ShmSafeUnmanagedChunk& entry : reinterpret_cast<const Layout&>(list).chunks) {
    const ShmSafeUnmanagedChunk chunk = entry;  // a copy, because the owner of the list may change the entry
    if (!chunk.isLogicalNullptr()) chunks.push_back(chunk);
  }
  return chunks;
}

bool same(const ShmSafeUnmanagedChunk& a, const ShmSafeUnmanagedChunk& b) {
  return std::memcmp(&a, &b, sizeof a) == 0;
}

}  // namespace

ChunkHoldings::ChunkHoldings(std::span<const std::byte> management, const iox::mepoo::MemoryManager& pools)
    : management_(management) {
  std::uint64_t end = 0;
  for (std::uint32_t i = 0; i < pools.getNumberOfMemPools(); ++i) {
    const auto pool = pools.getMemPoolInfo(i);
    end += std::uint64_t{pool.m_chunkSize} * pool.m_numChunks;
    pools_.push_back({end, pool.m_chunkSize});
  }
}

Holding ChunkHoldings::of(const SubscriberPortData& port) const {
  return sum_of(chunks_in(port.m_chunkReceiverData.m_chunksInUse));
}

Holding ChunkHoldings::of(const PublisherPortData& port, const SubscriberPortData* keeper) const {
  auto chunks = chunks_in(port.m_chunkSenderData.m_chunksInUse);
  if (keeper != nullptr)
    std::ranges::copy(chunks_in(keeper->m_chunkReceiverData.m_chunksInUse), std::back_inserter(chunks));
  const ShmSafeUnmanagedChunk last = port.m_chunkSenderData.m_lastChunkUnmanaged;
  const bool counted = std::ranges::any_of(chunks, [&](const auto& chunk) { return same(chunk, last); });
  if (!last.isLogicalNullptr() && !counted) chunks.push_back(last);
  return sum_of(chunks);
}

Holding ChunkHoldings::sum_of(std::span<const Chunk> chunks) const {
  Holding sum;
  sum.chunks = static_cast<std::uint32_t>(chunks.size());
  for (const Chunk& chunk : chunks) sum.bytes += bytes_of(chunk);
  return sum;
}

/// Returns the chunk size of the pool that has this chunk; 0 if the chunk was given back a moment ago.
std::uint64_t ChunkHoldings::bytes_of(const Chunk& chunk) const {
  static_assert(sizeof(Chunk) == sizeof(iox::rp::RelativePointerData));
  const std::uint64_t at = std::bit_cast<iox::rp::RelativePointerData>(chunk).offset();
  struct {
    std::uint64_t segment_id;
    std::uint64_t offset;
  } header{};  // iceoryx's object for a chunk begins with this relative pointer to the chunk
  static_assert(sizeof header == sizeof(iox::rp::RelativePointer<iox::mepoo::ChunkHeader>));
  if (at > management_.size() || management_.size() - at < sizeof header) return 0;
  std::memcpy(&header, management_.data() + at, sizeof header);
  const auto pool =
      std::ranges::find_if(pools_, [&](const PoolRange& range) { return header.offset < range.end; });
  return pool == pools_.end() ? 0 : pool->chunk_bytes;
}

}  // namespace sft::shm
