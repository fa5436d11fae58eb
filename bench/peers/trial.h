// One entrant in one case: a writer's process on the first core, and the readers' processes on the second
// one, which they share. One start serves for all sizes.
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
  std::vector<std::uint32_t> sizes;  ///< at most sizes_max
  Pace pace;
};

/// A record for each size. Names an entrant that failed on the standard error, and returns none then.
Records run(const Trial& trial, const Stage& stage);

}  // namespace sft::bench::peers
