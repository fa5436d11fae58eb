#include "shm_transport/sftd/pools.h"

#include <algorithm>
#include <array>
#include <string>

namespace sft::shm {

namespace {

struct SizeClass {
  std::size_t bytes;
  double share;        ///< the part of the budget for this size
  std::uint32_t most;  ///< more chunks of this size would be of no use
};

constexpr std::size_t KiB = 1024;
constexpr std::size_t MiB = 1024 * KiB;

// Each size is a little larger than a round number. So a body of that round size fits together with its
// header and index, and does not need the next larger size.
constexpr std::array size_classes{
    SizeClass{4 * KiB, 0.03, 4096},         SizeClass{16 * KiB, 0.04, 2048},
    SizeClass{64 * KiB + KiB, 0.06, 1024},  SizeClass{256 * KiB + 4 * KiB, 0.09, 512},
    SizeClass{MiB + 4 * KiB, 0.16, 256},    SizeClass{4 * MiB + 8 * KiB, 0.20, 128},
    SizeClass{8 * MiB + 8 * KiB, 0.20, 64}, SizeClass{largest_chunk_bytes, 0.22, 32},
};

constexpr std::uint32_t fewest = 2;
// A large size may take more than its share for its two chunks, but not more than this part of what remains.
constexpr double largest_part = 0.4;

std::size_t chunk_bytes(const SizeClass& size) { return size.bytes + chunk_header_bytes; }

std::uint32_t count_for(const SizeClass& size, double share_bytes, std::size_t remaining_bytes) {
  const auto chunk = static_cast<double>(chunk_bytes(size));
  const auto by_share = static_cast<std::uint32_t>(share_bytes / chunk);
  if (by_share >= fewest) return std::min(by_share, size.most);
  return fewest * chunk <= largest_part * static_cast<double>(remaining_bytes) ? fewest : 0;
}

}  // namespace

std::size_t PoolPlan::bytes() const {
  std::size_t sum = 0;
  for (const Pool& pool : pools) sum += pool.count * (pool.bytes + chunk_header_bytes);
  return sum;
}

PoolPlan plan_pools(std::size_t budget_bytes) {
  PoolPlan plan;
  std::size_t remaining = budget_bytes;
  double remaining_shares = 1.0;  // the sum of the shares of the sizes that have not had their turn
  for (auto size = size_classes.rbegin(); size != size_classes.rend(); ++size) {
    const double share = static_cast<double>(remaining) * size->share / remaining_shares;
    remaining_shares -= size->share;
    const std::uint32_t count = count_for(*size, share, remaining);
    if (count == 0) continue;
    plan.pools.insert(plan.pools.begin(), Pool{size->bytes, count});
    remaining -= count * chunk_bytes(*size);
  }
  if (plan.largest() < largest_chunk_bytes) {
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
