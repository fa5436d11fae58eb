// How a budget of shared memory is cut into chunks of fixed sizes, which is all that iceoryx can lend.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace sft::shm {

struct Pool {
  std::size_t bytes = 0;  ///< of a sample: header, index and body
  std::uint32_t count = 0;
};

struct PoolPlan {
  std::vector<Pool> pools;  ///< by size, the smallest first
  std::string remark;       ///< what the budget was too small for; empty if for nothing

  std::size_t bytes() const;
  std::size_t largest() const { return pools.empty() ? 0 : pools.back().bytes; }
};

inline constexpr std::size_t chunk_header_bytes = 40;         ///< iceoryx's, in front of each
inline constexpr std::size_t largest_chunk_bytes = 17 << 20;  ///< a body of 16 MiB, its header and its index
inline constexpr std::size_t smallest_budget_bytes = 4 << 20;

/// Every size gets its share of the budget. A size of which the budget does not hold at least two chunks (a
/// writer keeps the last one that it sent) is left out, and its share goes to the next smaller one.
PoolPlan plan_pools(std::size_t budget_bytes);

std::string format_bytes(std::size_t bytes);

}  // namespace sft::shm
