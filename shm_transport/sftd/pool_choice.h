// Chooses the pools of samples for the free space in /dev/shm, or says that there is too little space.
#pragma once

#include "shm_transport/sftd/groups.h"
#include "shm_transport/sftd/pools.h"
#include "shm_transport/sftd/settings.h"
#include "shm_transport/sftd/start_failure.h"

namespace sft::shm {

inline constexpr std::size_t smallest_shm_bytes = std::size_t{128} << 20;
inline constexpr std::size_t default_pool_bytes = std::size_t{320} << 20;

/// The memory for samples is as large as the settings say, or else half of the free space, up to
/// default_pool_bytes.
tl::expected<PoolPlan, StartFailure> choose_pools(const DaemonSettings& settings, const Groups& groups);

}  // namespace sft::shm
