// One entrant in one case. The writer's process is on the first core. The readers' processes share the second
// core. They are started once for all sizes.
#pragma once

#include <cstdint>
#include <vector>

#include "bench/peers/entrant.h"
#include "bench/peers/pace.h"
#include "bench/peers/record.h"
#include "bench/peers/stage.h"

namespace sft::bench::peers {

struct Trial {
  Case of;
  Entrant entrant;
  std::vector<std::uint32_t> sizes;  ///< the sizes of the messages, at most sizes_max sizes
  Pace pace;
};

/// Returns a record for each size. If the entrant failed, names it on the standard error, and returns no
/// records.
Records run(const Trial& trial, const Stage& stage);

}  // namespace sft::bench::peers
