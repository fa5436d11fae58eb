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

/// Limits that keep one program from taking all resources. The defaults are the limits of iceoryx.
struct Limits {
  std::uint32_t processes = processes_max;
  std::uint32_t publishers_per_process = writers_max;
  std::uint32_t subscribers_per_process = readers_max;  ///< each publisher also counts as a subscriber
};

/// The names of the groups whose members may use the memory. If both names are empty, the group that sftd
/// runs as may use it.
struct AccessSettings {
  std::string writers{};  ///< the group whose members may read and write samples
  std::string readers{};  ///< the group whose members may only read samples
};

struct DaemonSettings {
  /// The budget for samples; empty: determined by the free space of /dev/shm.
  std::optional<std::size_t> pool_bytes{};
  std::vector<Pool> pools{};          ///< the pools, sorted by size; empty: pools for the budget are chosen
  std::chrono::seconds idle_exit{0};  ///< time without clients after which the daemon ends; 0: never
  Limits limits{};
  AccessSettings access{};
};

}  // namespace sft::shm
