// Divides a budget of shared memory into chunks of fixed sizes, because iceoryx can only lend such chunks.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace sft::shm {

struct Pool {
  std::size_t bytes = 0;  ///< the largest sample in a chunk: header, index and body
  std::uint32_t count = 0;
  /// The number of chunks, at the end of the pool, of which only the headers have memory when the daemon
  /// starts. The rest of such a chunk is set aside by the first writer that takes the chunk
  /// (PreparedChunks::set_aside()).
  std::uint32_t on_demand = 0;
};

struct PoolPlan {
  std::vector<Pool> pools;  ///< the pools, sorted by the size of their chunks, the smallest first
  std::string remark;       ///< names the samples for which the budget is too small; empty if all samples fit

  std::size_t bytes() const;
  /// Returns the part of bytes() that takes memory only when it is used. The headers of its chunks have
  /// memory at once.
  std::size_t bytes_on_demand() const;
  std::size_t largest() const { return pools.empty() ? 0 : pools.back().bytes; }
};

/// Size of iceoryx's header before each chunk, in bytes.
inline constexpr std::size_t chunk_header_bytes = 40;
/// For a body of 64 MiB, its header and its index.
inline constexpr std::size_t largest_chunk_bytes = 65 << 20;
inline constexpr std::size_t smallest_budget_bytes = 4 << 20;
/// A budget up to this size is divided among chunks for samples of up to 16 MiB. The rest of a larger budget
/// goes to chunks for samples of more than 4 MiB.
inline constexpr std::size_t common_budget_bytes = std::size_t{320} << 20;

enum class Memory : bool { at_once, on_demand };

/// Gives each size of chunks its share of the budget. A size needs at least two chunks, because a writer
/// keeps the last chunk that it has sent. If the budget is too small for a size, the size is left out, and
/// the next smaller size gets its share. `large` says whether the chunks in addition to common_budget_bytes
/// have their memory at once.
PoolPlan plan_pools(std::size_t budget_bytes, Memory large = Memory::at_once);

std::string format_bytes(std::size_t bytes);

}  // namespace sft::shm
