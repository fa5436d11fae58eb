#include "shm_transport/host/pool_layout.h"

#include <algorithm>
#include <atomic>

#include "shm_transport/host/mapping.h"

namespace sft::shm {

namespace {

using iox::mepoo::MemPool;

struct FreeList {
  std::uint32_t chunk_count;
  std::uint32_t taken;  ///< the value in the list `next` for a chunk that is not in the list
  struct alignas(8) Head {
    std::uint32_t first;  ///< index of the first free chunk; `chunk_count` if the list is empty
    std::uint32_t changes;
  };
  std::atomic<Head> head;
  iox::rp::RelativePointer<std::uint32_t> next;
};
static_assert(sizeof(FreeList) == sizeof(iox::concurrent::LoFFLi));
static_assert(std::atomic<FreeList::Head>::is_always_lock_free);

struct PoolMembers {
  iox::rp::RelativePointer<std::uint8_t> begin;
  std::uint32_t chunk_bytes;
  std::uint32_t chunk_count;
  std::atomic<std::uint32_t> used;
  std::atomic<std::uint32_t> least_free;
  FreeList free;
};
static_assert(sizeof(PoolMembers) == sizeof(MemPool) && alignof(PoolMembers) == alignof(MemPool));

struct MemoryMembers {
  bool complete;
  std::uint32_t chunks;
  iox::cxx::vector<MemPool, iox::MAX_NUMBER_OF_MEMPOOLS> chunk_pools;
  iox::cxx::vector<MemPool, 1> header_pool;
};
static_assert(sizeof(MemoryMembers) == sizeof(iox::mepoo::MemoryManager));

PoolMembers& layout_of(MemPool& pool) { return reinterpret_cast<PoolMembers&>(pool); }

}  // namespace

PoolLayout::PoolLayout(MemPool& pool)
    : pool_(pool),
      begin_(reinterpret_cast<std::byte*>(layout_of(pool).begin.get())),
      chunk_bytes_(pool.getChunkSize()),
      chunk_count_(pool.getChunkCount()),
      next_free_(layout_of(pool).free.next.get()) {}

bool PoolLayout::is_within(std::span<const std::byte> samples, std::span<const std::byte> management) const {
  return contains(samples, begin_, std::size_t{chunk_count_} * chunk_bytes_) &&
         contains(management, next_free_, std::size_t{chunk_count_} * sizeof *next_free_);
}

std::optional<std::uint32_t> PoolLayout::index_of(const void* address) const {
  const auto offset = reinterpret_cast<std::uintptr_t>(address) - reinterpret_cast<std::uintptr_t>(begin_);
  if (offset >= std::size_t{chunk_count_} * chunk_bytes_ || offset % chunk_bytes_ != 0) return std::nullopt;
  return static_cast<std::uint32_t>(offset / chunk_bytes_);
}

std::optional<std::vector<bool>> PoolLayout::free_chunks() const {
  std::vector<bool> free(chunk_count_, false);
  for (std::uint32_t i = layout_of(pool_).free.head.load(std::memory_order_acquire).first; i != chunk_count_;
       i = __atomic_load_n(&next_free_[i], __ATOMIC_RELAXED)) {
    if (i > chunk_count_ || free[i]) return std::nullopt;
    free[i] = true;
  }
  return free;
}

std::size_t PoolLayout::next_free(std::span<std::uint32_t> chunks) const {
  std::uint32_t next = layout_of(pool_).free.head.load(std::memory_order_acquire).first;
  for (std::size_t i = 0; i < chunks.size(); ++i) {
    if (next >= chunk_count_) return i;
    chunks[i] = next;
    next = __atomic_load_n(&next_free_[next], __ATOMIC_RELAXED);
  }
  return chunks.size();
}

std::int64_t PoolLayout::overcount(const std::vector<bool>& free) const {
  const auto taken = std::int64_t{chunk_count_} - std::ranges::count(free, true);
  return std::int64_t{pool_.getUsedChunks()} - taken;
}

void PoolLayout::correct_count(std::int64_t too_many) {
  layout_of(pool_).used.fetch_sub(static_cast<std::uint32_t>(too_many), std::memory_order_relaxed);
}

/// Marks the chunk as taken before it frees the chunk, because iceoryx refuses to free a chunk without this
/// mark. The mark is missing if the last user was killed just before it marked the chunk, or while it gave
/// the chunk back.
void PoolLayout::free(std::uint32_t index) {
  __atomic_store_n(&next_free_[index], layout_of(pool_).free.taken, __ATOMIC_RELAXED);
  pool_.freeChunk(at(index));
}

std::vector<PoolLayout> pools_of(iox::mepoo::MemoryManager& memory) {
  auto& members = reinterpret_cast<MemoryMembers&>(memory);
  std::vector<PoolLayout> layouts;
  for (MemPool& pool : members.chunk_pools) layouts.emplace_back(pool);
  for (MemPool& pool : members.header_pool) layouts.emplace_back(pool);
  return layouts;
}

}  // namespace sft::shm
