#include "shm_transport/sftd/pool_layout.h"

#include <algorithm>
#include <atomic>

namespace sft::shm {

namespace {

using iox::mepoo::MemPool;

struct FreeList {
  std::uint32_t places;
  std::uint32_t taken;  ///< what stands in `next` for a place that is not in the list
  struct alignas(8) Head {
    std::uint32_t first;  ///< `places`: there is none
    std::uint32_t changes;
  };
  std::atomic<Head> head;
  iox::rp::RelativePointer<std::uint32_t> next;
};
static_assert(sizeof(FreeList) == sizeof(iox::concurrent::LoFFLi));
static_assert(std::atomic<FreeList::Head>::is_always_lock_free);

struct Pool {
  iox::rp::RelativePointer<std::uint8_t> begin;
  std::uint32_t place_bytes;
  std::uint32_t places;
  std::atomic<std::uint32_t> used;
  std::atomic<std::uint32_t> least_free;
  FreeList free;
};
static_assert(sizeof(Pool) == sizeof(MemPool) && alignof(Pool) == alignof(MemPool));

struct Pools {
  bool complete;
  std::uint32_t chunks;
  iox::cxx::vector<MemPool, iox::MAX_NUMBER_OF_MEMPOOLS> of_chunks;
  iox::cxx::vector<MemPool, 1> of_headers;
};
static_assert(sizeof(Pools) == sizeof(iox::mepoo::MemoryManager));

Pool& layout_of(MemPool& pool) { return reinterpret_cast<Pool&>(pool); }

}  // namespace

PoolLayout::PoolLayout(MemPool& pool)
    : pool_(pool),
      begin_(reinterpret_cast<std::byte*>(layout_of(pool).begin.get())),
      place_bytes_(pool.getChunkSize()),
      places_(pool.getChunkCount()),
      next_free_(layout_of(pool).free.next.get()) {}

std::optional<std::uint32_t> PoolLayout::place_of(const void* address) const {
  const auto offset = reinterpret_cast<std::uintptr_t>(address) - reinterpret_cast<std::uintptr_t>(begin_);
  if (offset >= std::size_t{places_} * place_bytes_ || offset % place_bytes_ != 0) return std::nullopt;
  return static_cast<std::uint32_t>(offset / place_bytes_);
}

std::vector<bool> PoolLayout::free_places() const {
  std::vector<bool> free(places_, false);
  for (std::uint32_t i = layout_of(pool_).free.head.load(std::memory_order_acquire).first; i != places_;
       i = __atomic_load_n(&next_free_[i], __ATOMIC_RELAXED)) {
    if (i > places_ || free[i]) return {};
    free[i] = true;
  }
  return free;
}

std::int64_t PoolLayout::counted_too_many(const std::vector<bool>& free) const {
  const auto taken = std::int64_t{places_} - std::ranges::count(free, true);
  return std::int64_t{pool_.getUsedChunks()} - taken;
}

void PoolLayout::correct_count(std::int64_t too_many) {
  layout_of(pool_).used.fetch_sub(static_cast<std::uint32_t>(too_many), std::memory_order_relaxed);
}

/// Its last user may have been about to mark it as taken, or to put it back.
void PoolLayout::free(std::uint32_t place) {
  __atomic_store_n(&next_free_[place], layout_of(pool_).free.taken, __ATOMIC_RELAXED);
  pool_.freeChunk(at(place));
}

std::vector<PoolLayout> pools_of(iox::mepoo::MemoryManager& memory) {
  auto& pools = reinterpret_cast<Pools&>(memory);
  std::vector<PoolLayout> layouts;
  for (MemPool& pool : pools.of_chunks) layouts.emplace_back(pool);
  for (MemPool& pool : pools.of_headers) layouts.emplace_back(pool);
  return layouts;
}

}  // namespace sft::shm
