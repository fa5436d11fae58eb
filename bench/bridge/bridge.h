// The groups of figures of this benchmark.
#pragma once

#include <vector>

#include "bench/common/report.h"

namespace sft::bench {

struct BridgeScale {
  int rounds = 3;
  double seconds = 10;
};

/// Measures the samples that bridges carry. A lidar on the robot publishes 6.3 MB at 10 Hz. A reader on the
/// robot receives whole clouds in shared memory. An unmodified DDS reader at the station receives x, y and
/// z of every fourth point, 31 Mbit/s. A small topic is carried to the station, too.
std::vector<Figure> bridge_carrying(const BridgeScale& scale);

/// Measures the cost of bridges that carry no samples.
std::vector<Figure> bridge_idle(const BridgeScale& scale);

}  // namespace sft::bench
