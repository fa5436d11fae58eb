#include "bench/isolation/observation.h"

#include <algorithm>
#include <limits>

#include "bench/common/statistics.h"

namespace sft::bench::isolation {

namespace {

double us(std::int64_t ns) { return static_cast<double>(ns) / 1000; }

std::vector<std::vector<double>> all_of(const std::vector<Observation>& rounds,
                                        std::vector<double> Observation::*times) {
  std::vector<std::vector<double>> all;
  for (const Observation& round : rounds) all.push_back(round.*times);
  return all;
}

}  // namespace

Observation observe(const Board& board, const Numbers& numbers, const Resources& resources) {
  Observation seen{.resources = resources};
  for (std::uint64_t n = numbers.first; n < numbers.end; ++n) {
    const std::int64_t sent = board.sent_ns[n];
    seen.late_us.push_back(us(sent - board.due_ns[n]));
    if (board.returned_ns[n] != 0) seen.publish_us.push_back(us(board.returned_ns[n] - sent));
    seen.page_faults += board.page_faults[n];
    for (std::size_t reader = 0; reader < local_readers; ++reader) {
      const std::int64_t arrived = board.arrived_ns[reader][n];
      if (arrived == 0) ++seen.lost;
      if (arrived != 0) seen.local_us.push_back(us(arrived - sent));
    }
    if (board.arrived_ns[remote_reader][n] != 0) ++seen.remote_received;
  }
  return seen;
}

Times times_over(std::vector<std::vector<double>> rounds) {
  std::erase_if(rounds, [](const auto& times) { return times.empty(); });
  if (rounds.empty()) {
    constexpr double none = std::numeric_limits<double>::quiet_NaN();
    return {none, none, none, none};
  }
  Rounds quantiles;
  Times result;
  for (std::vector<double>& times : rounds) {
    result.worst = std::max(result.worst, std::ranges::max(times));
    result.p99_of_worst_round = std::max(result.p99_of_worst_round, quantile(times, 0.99));
    quantiles.add(times);
  }
  result.p50 = quantiles.p50();
  result.p99 = quantiles.p99();
  return result;
}

Summary summarize(const std::vector<Observation>& rounds) {
  Summary summary{.local = times_over(all_of(rounds, &Observation::local_us)),
                  .publish = times_over(all_of(rounds, &Observation::publish_us))};
  Resources all;
  std::size_t published = 0;
  for (const Observation& round : rounds) {
    all.s += round.resources.s;
    all.local_cpu_s += round.resources.local_cpu_s;
    all.remote_cpu_s += round.resources.remote_cpu_s;
    published += round.late_us.size();
    summary.page_faults += round.page_faults;
    summary.lost += round.lost;
    summary.remote_received += round.remote_received;
  }
  summary.published_hz = static_cast<double>(published) / all.s;
  summary.cpu_percent = 100 * all.local_cpu_s / all.s;
  summary.remote_cpu_percent = 100 * all.remote_cpu_s / all.s;
  return summary;
}

std::int64_t next_turn_ns(std::int64_t due_ns, std::int64_t now_ns, std::int64_t period_ns) {
  const std::int64_t over = std::max<std::int64_t>(0, now_ns - due_ns) / period_ns;
  return due_ns + (over + 1) * period_ns;
}

}  // namespace sft::bench::isolation
