// What sftd can be told: by its command line and its configuration file.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "shm_transport/sftd/pools.h"

namespace sft::shm {

/// Of what one program may take from the others. By default as much as iceoryx has room for.
struct Limits {
  std::uint32_t processes = 300;
  std::uint32_t publishers_per_process = 506;
  std::uint32_t subscribers_per_process = 1024;  ///< each publisher counts as one, too
};

/// Names of the groups whose members may use the memory; empty: the group that sftd runs as.
struct AccessSettings {
  std::string writers{};
  std::string readers{};  ///< may read samples and not write them
};

struct DaemonSettings {
  std::optional<std::size_t> pool_bytes{};  ///< for samples; by default what /dev/shm has room for
  std::vector<Pool> pools{};                ///< exactly these, by size, instead of a budget; empty: by budget
  std::chrono::seconds idle_exit{0};        ///< 0: never
  Limits limits{};
  AccessSettings access{};
};

}  // namespace sft::shm
