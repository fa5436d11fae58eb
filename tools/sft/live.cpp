#include "tools/sft/live.h"

#include <algorithm>
#include <chrono>

namespace sft::tool {

void report_every_second(const LiveOptions& options, Stop& stop, const std::function<void()>& report) {
  using Clock = std::chrono::steady_clock;
  const bool ends = options.for_s > 0;
  const auto end = Clock::now() + seconds(options.for_s);
  while (!stop.requested()) {
    std::chrono::nanoseconds pause = std::chrono::seconds(1);
    if (ends) pause = std::min<std::chrono::nanoseconds>(pause, end - Clock::now());
    if (pause.count() <= 0) break;
    const bool stopped = stop.wait_for(pause);
    if (!stopped) report();
  }
}

}  // namespace sft::tool
