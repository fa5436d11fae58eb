#include "shm_transport/sftd/pool_choice.h"

#include <sys/statvfs.h>
#include <unistd.h>

#include <algorithm>

#include "shm_transport/sftd/host_memory.h"

namespace sft::shm {

namespace {

struct Space {
  std::size_t total = 0;
  std::size_t free = 0;
};

Space shm_space() {
  struct statvfs status {};
  if (statvfs("/dev/shm", &status) != 0) return {};
  return {status.f_blocks * status.f_frsize, status.f_bavail * status.f_frsize};
}

std::size_t ram_bytes() {
  return static_cast<std::size_t>(sysconf(_SC_PHYS_PAGES)) * static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
}

tl::unexpected<StartFailure> refuse_for_space(const Space& space, std::size_t needed) {
  return refuse(
      ExitCode::no_space,
      "/dev/shm has " + format_bytes(space.total) + ", of which " + format_bytes(space.free) +
          " are free, and shared memory needs " + format_bytes(needed) +
          "; enlarge /dev/shm (docker run --shm-size=512m, or mount -o remount,size=512m /dev/shm); until "
          "then samples go over UDP");
}

tl::expected<PoolPlan, StartFailure> configured_pools(const DaemonSettings& settings, const Groups& groups,
                                                      const Space& space) {
  PoolPlan plan{settings.pools, {}};
  const std::size_t needed = HostMemory::management_bytes(make_config(plan, groups)) + plan.bytes();
  if (space.free < needed) return refuse_for_space(space, needed);
  return plan;
}

}  // namespace

std::size_t default_budget(const HostBytes& host) {
  const std::size_t share = std::min(host.free_shm / 2, host.ram / 4);
  return std::clamp(share, smallest_budget_bytes, default_pool_bytes);
}

tl::expected<PoolPlan, StartFailure> choose_pools(const DaemonSettings& settings, const Groups& groups) {
  const Space space = shm_space();
  if (space.total < smallest_shm_bytes) return refuse_for_space(space, smallest_shm_bytes);
  if (!settings.pools.empty()) return configured_pools(settings, groups, space);
  const std::size_t most = settings.pool_bytes.value_or(default_pool_bytes);
  const std::size_t management = HostMemory::management_bytes(make_config(plan_pools(most), groups));
  const std::size_t least = settings.pool_bytes.value_or(2 * smallest_budget_bytes);
  if (space.free < management + least) return refuse_for_space(space, management + least);
  if (settings.pool_bytes) return plan_pools(*settings.pool_bytes);
  return plan_pools(default_budget({space.free - management, ram_bytes()}), Memory::on_demand);
}

}  // namespace sft::shm
