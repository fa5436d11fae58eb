#include "shm_transport/host/prepared_chunks.h"

#include <fcntl.h>
#include <sys/mman.h>
#include <sys/vfs.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>

namespace sft::shm {

namespace {

/// The maximum number of bytes that one system call maps. During the call the mappings of the process are
/// locked, so page faults of other threads may have to wait.
constexpr std::size_t mapped_in_a_call = std::size_t{1} << 20;

/// Returns false if the system refuses to map the pages: if it is older than Linux 5.14, or has too little
/// memory. The pages are then mapped when they are first used.
bool map(const std::byte* begin, const std::byte* end) noexcept {
  static const auto page = static_cast<std::uintptr_t>(::sysconf(_SC_PAGESIZE));
  auto at = reinterpret_cast<std::uintptr_t>(begin) / page * page;
  const auto last = reinterpret_cast<std::uintptr_t>(end);
  for (; at < last; at += mapped_in_a_call) {
    const std::size_t bytes = std::min<std::size_t>(mapped_in_a_call, last - at);
    if (::madvise(reinterpret_cast<void*>(at), bytes, MADV_POPULATE_WRITE) != 0) return false;
  }
  return true;
}

}  // namespace

/// Casts the constness away, because PoolLayout could change pools. PreparedChunks does not change them.
PreparedChunks::PreparedChunks(const iox::mepoo::MemoryManager& pools, std::span<const std::byte> samples,
                               std::span<const std::byte> management, int samples_file)
    : samples_(samples.data()), file_(samples_file) {
  for (const PoolLayout& layout : pools_of(const_cast<iox::mepoo::MemoryManager&>(pools)))
    pools_.emplace_back(layout, layout.is_within(samples, management) ? layout.chunk_count() : 0);
}

void PreparedChunks::note(std::uint32_t pool, std::size_t bytes) noexcept {
  if (pool >= pools_.size()) return;  // another program has changed the number of pools
  std::atomic<std::size_t>& most = pools_[pool].bytes;
  for (std::size_t known = most.load(std::memory_order_relaxed); known < bytes;)
    if (most.compare_exchange_weak(known, bytes, std::memory_order_relaxed)) return;
}

void PreparedChunks::prepare() noexcept {
  if (inside_.test_and_set(std::memory_order_acquire)) return;
  std::size_t budget = mapped_at_once, missing = 0, missing_bytes = 0;
  for (Pool& pool : pools_) {
    const std::size_t bytes = pool.bytes.load(std::memory_order_relaxed);
    if (missing > 0) map_free(pool, missing, missing_bytes, budget);
    missing = bytes < large_bytes ? 0 : chunks_ahead - map_free(pool, chunks_ahead, bytes, budget);
    missing_bytes = bytes;
  }
  inside_.clear(std::memory_order_release);
}

bool PreparedChunks::set_aside(const iox::mepoo::ChunkHeader& chunk, std::size_t bytes) noexcept {
  for (Pool& pool : pools_) {
    if (pool.mapped.empty()) continue;
    if (const auto index = pool.layout.index_of(&chunk)) return set_aside(pool, *index, bytes);
  }
  return true;
}

/// Returns whether the first `bytes` of the chunk have memory, no matter which process has requested it.
bool PreparedChunks::has_memory(Pool& pool, std::uint32_t chunk, std::uint32_t bytes) noexcept {
  if (file_ < 0 || pool.layout.chunk_bytes() < on_demand_bytes) return true;
  std::atomic<std::uint32_t>& known = pool.set_aside[chunk];
  if (known.load(std::memory_order_relaxed) >= bytes) return true;
  const off_t begin = pool.layout.at(chunk) - samples_;
  if (::lseek(file_, begin, SEEK_HOLE) < begin + bytes) return false;
  known.store(bytes, std::memory_order_relaxed);
  return true;
}

/// Requests the memory in several parts, because a signal ends a call, and the system then takes back all
/// memory of that call. If the host has too little memory for all parts, requests nothing: the parts that
/// could be had would be useless here and missing for other programs.
bool PreparedChunks::set_aside(Pool& pool, std::uint32_t chunk, std::size_t bytes) noexcept {
  constexpr std::uint32_t part_bytes = 1 << 20;
  const auto wanted = static_cast<std::uint32_t>(std::min<std::size_t>(bytes, pool.layout.chunk_bytes()));
  if (has_memory(pool, chunk, wanted)) return true;
  std::atomic<std::uint32_t>& known = pool.set_aside[chunk];
  std::uint32_t has = known.load(std::memory_order_relaxed);
  struct statfs host {};
  if (::fstatfs(file_, &host) != 0 ||
      static_cast<std::uint64_t>(host.f_bavail) * static_cast<std::uint64_t>(host.f_bsize) < wanted - has)
    return false;
  const off_t begin = pool.layout.at(chunk) - samples_;
  while (has < wanted) {
    const std::uint32_t part = std::min(part_bytes, wanted - has);
    if (::fallocate(file_, FALLOC_FL_KEEP_SIZE, begin + has, part) == 0) {
      has += part;
      known.store(has, std::memory_order_relaxed);
    } else if (errno != EINTR) {
      return false;
    }
  }
  return true;
}

/// Maps the next free chunks of the pool, at most `chunks`. Returns how many such chunks the pool has,
/// whether or not all could be mapped.
std::size_t PreparedChunks::map_free(Pool& pool, std::size_t chunks, std::size_t bytes,
                                     std::size_t& budget) noexcept {
  if (pool.mapped.empty()) return chunks;
  const std::uint32_t used = std::min(static_cast<std::uint32_t>(bytes), pool.layout.chunk_bytes());
  std::array<std::uint32_t, chunks_ahead> next;
  const std::size_t count = pool.layout.next_free(std::span(next).first(chunks));
  for (const std::uint32_t chunk : std::span(next).first(count)) {
    std::uint32_t& mapped = pool.mapped[chunk];
    if (mapped >= used || budget == 0 || !has_memory(pool, chunk, used)) continue;
    budget -= std::min<std::size_t>(budget, used - mapped);
    const std::byte* const begin = pool.layout.at(chunk);
    if (map(begin + mapped, begin + used)) mapped = used;
  }
  return count;
}

}  // namespace sft::shm
