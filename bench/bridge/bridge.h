// The groups of figures of this benchmark.
#pragma once

#include <vector>

#include "bench/common/report.h"

namespace sft::bench {

struct BridgeScale {
  int rounds = 3;
  double seconds = 10;
};

/// A lidar sends 6.3 MB at 10 Hz on the robot. A reader there gets whole clouds in shared memory, and an
/// unmodified DDS reader at the station gets x, y and z of every fourth point, 31 Mbit/s. A small topic goes
/// the same way.
std::vector<Figure> bridge_carrying(const BridgeScale& scale);

/// The cost of bridges that carry no samples.
std::vector<Figure> bridge_idle(const BridgeScale& scale);

}  // namespace sft::bench
