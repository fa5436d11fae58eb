#include "shm_transport/sftd/pools.h"

#include <algorithm>
#include <array>
#include <span>
#include <string>

namespace sft::shm {

namespace {

struct SizeClass {
  std::size_t bytes;
  double share;        ///< the part of the budget that chunks of this size get
  std::uint32_t most;  ///< the largest useful number of chunks of this size
};

constexpr std::size_t KiB = 1024;
constexpr std::size_t MiB = 1024 * KiB;

// Each size is a little larger than a round number. So a body of that round size fits into the chunk
// together with its header and index, and does not need a chunk of the next larger size.
constexpr std::size_t of_4_mib = 4 * MiB + 8 * KiB, of_8_mib = 8 * MiB + 8 * KiB, of_16_mib = 17 * MiB,
                      of_32_mib = 33 * MiB;

constexpr std::array common_sizes{
    SizeClass{4 * KiB, 0.03, 4096},        SizeClass{16 * KiB, 0.04, 2048},
    SizeClass{64 * KiB + KiB, 0.06, 1024}, SizeClass{256 * KiB + 4 * KiB, 0.09, 512},
    SizeClass{MiB + 4 * KiB, 0.16, 256},   SizeClass{of_4_mib, 0.20, 128},
    SizeClass{of_8_mib, 0.20, 64},         SizeClass{of_16_mib, 0.22, 32},
};
// Sizes for clouds of several lidars (8 MiB), and for images of 4K cameras and large clouds (32 MiB).
constexpr std::array large_sizes{
    SizeClass{of_8_mib, 0.30, 512},
    SizeClass{of_16_mib, 0.10, 256},
    SizeClass{of_32_mib, 0.40, 256},
    SizeClass{largest_chunk_bytes, 0.20, 128},
};

constexpr std::uint32_t fewest = 2;
// A large size whose share is too small for two chunks may take more than its share, but at most this part
// of the remaining budget.
constexpr double largest_part = 0.4, largest_part_of_large = 0.6;
// If the budget is much greater than common_budget_bytes, this part of it is divided among the common
// sizes, and the rest among the large sizes.
constexpr double common_part = 0.3;

std::size_t chunk_bytes(std::size_t bytes) { return bytes + chunk_header_bytes; }

std::uint32_t count_for(const SizeClass& size, double share_bytes, double part_bytes) {
  const auto chunk = static_cast<double>(chunk_bytes(size.bytes));
  const auto by_share = static_cast<std::uint32_t>(share_bytes / chunk);
  if (by_share >= fewest) return std::min(by_share, size.most);
  return fewest * chunk <= part_bytes ? fewest : 0;
}

/// Divides the budget among the sizes. The pools are sorted by size, the smallest first.
std::vector<Pool> divide(std::size_t budget_bytes, std::span<const SizeClass> sizes,
                         double largest_part_of_rest) {
  std::vector<Pool> pools;
  std::size_t remaining = budget_bytes;
  double remaining_shares = 1.0;  // the sum of the shares of the sizes that are not yet handled
  for (auto size = sizes.rbegin(); size != sizes.rend(); ++size) {
    const auto rest = static_cast<double>(remaining);
    const std::uint32_t count =
        count_for(*size, rest * size->share / remaining_shares, largest_part_of_rest * rest);
    remaining_shares -= size->share;
    if (count == 0) continue;
    pools.insert(pools.begin(), Pool{.bytes = size->bytes, .count = count});
    remaining -= count * chunk_bytes(size->bytes);
  }
  return pools;
}

/// Adds the chunks to the plan's pool of the same size, or as a new pool if the plan has no such pool.
void add(PoolPlan& plan, const Pool& more, Memory memory) {
  const auto at = std::ranges::lower_bound(plan.pools, more.bytes, {}, &Pool::bytes);
  const auto pool = at != plan.pools.end() && at->bytes == more.bytes
                        ? at
                        : plan.pools.insert(at, Pool{.bytes = more.bytes});
  pool->count += more.count;
  if (memory == Memory::on_demand) pool->on_demand += more.count;
}

}  // namespace

std::size_t PoolPlan::bytes() const {
  std::size_t sum = 0;
  for (const Pool& pool : pools) sum += pool.count * chunk_bytes(pool.bytes);
  return sum;
}

std::size_t PoolPlan::bytes_on_demand() const {
  std::size_t sum = 0;
  for (const Pool& pool : pools) sum += pool.on_demand * chunk_bytes(pool.bytes);
  return sum;
}

PoolPlan plan_pools(std::size_t budget_bytes, Memory large) {
  const auto part = static_cast<std::size_t>(common_part * static_cast<double>(budget_bytes));
  const std::size_t common = std::min(budget_bytes, std::max(common_budget_bytes, part));
  PoolPlan plan{divide(common, common_sizes, largest_part), {}};
  for (const Pool& pool : divide(budget_bytes - common, large_sizes, largest_part_of_large))
    add(plan, pool, large);
  if (plan.largest() < of_16_mib) {
    plan.remark = "samples of more than " + format_bytes(plan.largest()) +
                  " do not fit into shared memory and will go over UDP; enlarge /dev/shm or give --pool-mib";
  }
  return plan;
}

std::string format_bytes(std::size_t bytes) {
  if (bytes < MiB) return std::to_string(bytes / KiB) + " KiB";
  const std::size_t tenths = (bytes * 10 + MiB / 2) / MiB;
  return std::to_string(tenths / 10) + "." + std::to_string(tenths % 10) + " MiB";
}

}  // namespace sft::shm
