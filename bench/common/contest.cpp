#include "bench/common/contest.h"

#include <algorithm>
#include <limits>

#include "bench/common/pair.h"

namespace sft::bench {

namespace {

constexpr double batch_ns_min = 100'000;

double time_ns(const Batch& batch, std::size_t times) {
  const auto begin = now_ns();
  batch(times);
  return static_cast<double>(now_ns() - begin);
}

std::size_t times_per_batch(const Batch& batch) {
  std::size_t times = 1;
  while (time_ns(batch, times) < batch_ns_min) times *= 2;
  return times;
}

}  // namespace

std::vector<double> best_times_ns(std::vector<Batch> contenders, int rounds) {
  std::vector<std::size_t> times;
  for (const Batch& batch : contenders) times.push_back(times_per_batch(batch));
  std::vector<double> best(contenders.size(), std::numeric_limits<double>::max());
  for (int round = 0; round < rounds; ++round) {
    for (std::size_t i = 0; i < contenders.size(); ++i)
      best[i] = std::min(best[i], time_ns(contenders[i], times[i]) / static_cast<double>(times[i]));
  }
  return best;
}

}  // namespace sft::bench
