// Measures the way from publish to callback between two hosts that sleep in between: of large samples the
// worst, and of small ones the median.
#include <algorithm>
#include <array>
#include <limits>

#include "bench/common/statistics.h"
#include "bench/many/many.h"
#include "bench/many/tally.h"
#include "bench/udp/one_way.h"

namespace sft::bench {

namespace {

double median_us(const std::vector<double>& times_us) { return median_if_any(times_us); }
double worst_ms(const std::vector<double>& times_us) {
  return times_us.empty() ? std::numeric_limits<double>::quiet_NaN() : std::ranges::max(times_us) / 1000;
}

struct Contest {
  const char* name;
  Paced paced;
  Contender rival;
  const char* rival_name;
  double bound;
  Tally tally{};

  template <class Measure>
  void run(const TwoHosts& hosts, Measure measure) {
    tally.add_ours(measure(one_way_times(sft_peer, paced, hosts)));
    tally.add_reference(measure(one_way_times(rival, paced, hosts)));
  }
};

}  // namespace

std::vector<Figure> worst_large(const ManyScale& scale) {
  const TwoHosts hosts(Trains::whole);
  // The first tenth of 27 does not count.
  Contest contest{.name = "worst_6.3MB",
                  .paced = {.topic = {.bulk_bytes = 6'300'000}, .messages = 27, .period_us = 100'000},
                  .rival = raw_tcp_peer,
                  .rival_name = "the worst of TCP's 25",
                  .bound = 1.5};
  for (int round = 0; round < scale.rounds; ++round) contest.run(hosts, worst_ms);
  return {contest.tally.figure(contest.name, "ms", contest.rival_name, contest.bound)};
}

std::vector<Figure> paced(const ManyScale& scale) {
  const TwoHosts hosts(Trains::whole);
  const Topic small{.reliable = false};
  const std::uint64_t shortened = scale.quick ? 5 : 1;
  std::array contests{
      Contest{"paced_64B_10Hz", {small, 50 / shortened, 100'000}, raw_udp_peer, "raw UDP", 1.3},
      Contest{"paced_64B_100Hz", {small, 300 / shortened, 10'000}, raw_udp_peer, "raw UDP", 1.3},
      Contest{"paced_64B_1kHz", {small, 2000 / shortened, 1000}, raw_udp_peer, "raw UDP", 1.3},
      Contest{"paced_16kB", {{.bulk_bytes = 16'000}, 300 / shortened, 10'000}, raw_tcp_peer, "TCP", 1.15}};
  for (int round = 0; round < scale.rounds; ++round) {
    for (Contest& contest : contests) contest.run(hosts, median_us);
  }
  std::vector<Figure> figures;
  for (const Contest& contest : contests)
    figures.push_back(contest.tally.figure(contest.name, "us", contest.rival_name, contest.bound));
  return figures;
}

}  // namespace sft::bench
