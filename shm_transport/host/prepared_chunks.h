// Prepares the memory of the chunks that writers of this process will probably take next. The system maps
// each page of a process when the page is used for the first time, which takes longer than copying the
// page: a sample of 6 MB causes 1,500 page faults. The next chunks are known, because a pool has its free
// chunks in a list and lends the first chunk of that list.
//
// Some large chunks of the daemon have no memory before they are used (sftd/pools.h). A writer requests
// memory from the system before it writes into such a chunk, because a write without memory would end the
// process.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "shm_transport/host/pool_layout.h"

namespace sft::shm {

/// All writers of a session share one object. It uses two segments of the daemon, which must stay mapped:
/// `samples` has the chunks, and `management` describes them. Other programs can write both. A pool outside
/// of these segments is ignored.
class PreparedChunks {
 public:
  /// `samples_file` is the file of `samples`; -1: all chunks have memory.
  PreparedChunks(const iox::mepoo::MemoryManager& pools, std::span<const std::byte> samples,
                 std::span<const std::byte> management, int samples_file = -1);

  /// Notes that a writer has taken a chunk of that pool, and uses its first `bytes`. Any thread may call
  /// this.
  void note(std::uint32_t pool, std::size_t bytes) noexcept;

  /// Maps the first `chunks_ahead` free chunks of each pool from which chunks for large samples were taken,
  /// up to the size of the largest such sample. Each page is mapped once. If a pool has fewer free chunks,
  /// chunks of the next larger pool are mapped as well. Chunks without memory are skipped. No byte is
  /// changed. A thread that may be delayed must call this regularly. Returns at once while another thread
  /// is in the function. Returns early after it has mapped `mapped_at_once` bytes; the next call continues.
  void prepare() noexcept;

  /// Requests memory for a chunk that a writer has taken, and whose first `bytes` it will write, including
  /// the header of the chunk. Returns false if the host has no memory for them: the writer must then write
  /// only the header. The request to the system is made once for each chunk that may lack memory. Any
  /// thread may call this.
  bool set_aside(const iox::mepoo::ChunkHeader& chunk, std::size_t bytes) noexcept;

  /// Chunks of this size or more may lack memory. Smaller chunks have all their memory from the beginning.
  static constexpr std::size_t on_demand_bytes = std::size_t{8} << 20;
  /// The number of free chunks that are mapped in advance. While samples flow, a publisher at 100 Hz takes
  /// this number of chunks between two calls of prepare() (TickPace).
  static constexpr std::size_t chunks_ahead = 5;
  /// Samples smaller than this are not prepared, since they have few pages.
  static constexpr std::size_t large_bytes = 256 * 1024;
  /// The maximum number of bytes that one call of prepare() maps, which takes a few milliseconds.
  static constexpr std::size_t mapped_at_once = std::size_t{32} << 20;

 private:
  struct Pool {
    explicit Pool(const PoolLayout& of, std::size_t chunks) : layout(of), mapped(chunks), set_aside(chunks) {}
    const PoolLayout layout;
    /// The maximum number of bytes that a sample has used of a chunk; 0: no chunk was taken.
    std::atomic<std::size_t> bytes{0};
    // Only prepare() changes the next member, and only one thread at a time is in prepare().
    std::vector<std::uint32_t> mapped;  ///< by chunk: number of mapped bytes; empty: the pool is ignored
    /// By chunk: the number of bytes that certainly have memory. If two threads write this number at the
    /// same time, the number of either thread may stay.
    std::vector<std::atomic<std::uint32_t>> set_aside;
  };
  std::size_t map_free(Pool& pool, std::size_t chunks, std::size_t bytes, std::size_t& budget) noexcept;
  bool has_memory(Pool& pool, std::uint32_t chunk, std::uint32_t bytes) noexcept;
  bool set_aside(Pool& pool, std::uint32_t chunk, std::size_t bytes) noexcept;

  const std::byte* const samples_;  ///< address of the beginning of the file
  const int file_;
  std::deque<Pool> pools_;
  std::atomic_flag inside_;
};

}  // namespace sft::shm
