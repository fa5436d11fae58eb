// Chooses the pools of samples for the free space in /dev/shm, or returns an error if there is too little
// space.
#pragma once

#include "shm_transport/sftd/groups.h"
#include "shm_transport/sftd/pools.h"
#include "shm_transport/sftd/settings.h"
#include "shm_transport/sftd/start_failure.h"

namespace sft::shm {

inline constexpr std::size_t smallest_shm_bytes = std::size_t{128} << 20;
inline constexpr std::size_t default_pool_bytes = std::size_t{1} << 30;

/// The memory of the host in bytes: the RAM, and the free space of /dev/shm without the part that the
/// management segment needs.
struct HostBytes {
  std::size_t free_shm = 0;
  std::size_t ram = 0;
};

/// Returns the memory for samples if the settings do not give it: half of the free space or a quarter of
/// the RAM, whichever is less, up to default_pool_bytes.
std::size_t default_budget(const HostBytes& host);

/// Returns the pools. Their memory for samples has the size in the settings, or default_budget() if the
/// settings give no size. Memory whose size is in the settings is set aside at once.
tl::expected<PoolPlan, StartFailure> choose_pools(const DaemonSettings& settings, const Groups& groups);

}  // namespace sft::shm
