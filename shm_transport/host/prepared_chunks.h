// Prepares the memory of the chunks that writers of this process will probably take next. The system maps
// each page of a process when it is used for the first time, which takes longer than to copy that page: for a
// sample of 6 MB these are 1,500 page faults. A pool has its free chunks in a list, and lends the first one.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <span>
#include <vector>

#include "shm_transport/host/pool_layout.h"

namespace sft::shm {

/// All writers of a session share one object. The segments of the daemon, which stay mapped: `samples` has
/// the chunks, `management` describes them. Other programs can write both. A pool that does not lie in them
/// is left alone.
class PreparedChunks {
 public:
  PreparedChunks(const iox::mepoo::MemoryManager& pools, std::span<const std::byte> samples,
                 std::span<const std::byte> management);

  /// A writer has taken a chunk of that pool, of which it uses the first `bytes`. Any thread.
  void note(std::uint32_t pool, std::size_t bytes) noexcept;

  /// Maps the first `chunks_ahead` free chunks of each pool from which large samples were taken, as far as
  /// the largest of these reached, and each page once. Where a pool has fewer chunks, those of the next
  /// larger one follow. It changes no byte. To be called now and then, by threads for which nobody waits.
  /// Returns at once while another thread is inside, and early when it has mapped much; the next call goes
  /// on.
  void prepare() noexcept;

  /// A publisher at 100 Hz takes so many between two calls of a node while samples flow (TickPace).
  static constexpr std::size_t chunks_ahead = 5;
  static constexpr std::size_t large_bytes = 256 * 1024;                ///< smaller samples have few pages
  static constexpr std::size_t mapped_at_once = std::size_t{32} << 20;  ///< takes a few milliseconds

 private:
  struct Pool {
    explicit Pool(const PoolLayout& of, std::size_t chunks) : layout(of), mapped(chunks) {}
    const PoolLayout layout;
    std::atomic<std::size_t> bytes{0};  ///< the most that was used of a chunk; 0: none was taken
    // Used by the thread that is inside.
    std::vector<std::uint32_t> mapped;  ///< bytes of each chunk; empty: the pool is left alone
  };
  static std::size_t map_free(Pool& pool, std::size_t chunks, std::size_t bytes,
                              std::size_t& budget) noexcept;

  std::deque<Pool> pools_;
  std::atomic_flag inside_;
};

}  // namespace sft::shm
