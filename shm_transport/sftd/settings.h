// The settings of sftd, from its command line and its configuration file.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "shm_transport/host/iceoryx.h"
#include "shm_transport/sftd/pools.h"

namespace sft::shm {

/// Limits that keep one program from taking everything from the others. The defaults are as much as iceoryx
/// has room for.
struct Limits {
  std::uint32_t processes = processes_max;
  std::uint32_t publishers_per_process = writers_max;
  std::uint32_t subscribers_per_process = readers_max;  ///< each publisher counts as a subscriber, too
};

/// The names of the groups whose members may use the memory. If they are empty, the group that sftd runs as
/// may use it.
struct AccessSettings {
  std::string writers{};  ///< may read and write samples
  std::string readers{};  ///< may only read samples
};

struct DaemonSettings {
  std::optional<std::size_t> pool_bytes{};  ///< the budget for samples; empty: what /dev/shm allows
  std::vector<Pool> pools{};          ///< these pools, sorted by size; empty: pools for the budget are chosen
  std::chrono::seconds idle_exit{0};  ///< 0: never
  Limits limits{};
  AccessSettings access{};
};

}  // namespace sft::shm
