// Measures the time from publish to callback between two hosts that sleep in between: the worst time of
// large samples, and the median of small ones. For small samples, also measures the processor time.
#include <algorithm>
#include <array>
#include <limits>
#include <optional>
#include <string>

#include "bench/common/statistics.h"
#include "bench/many/many.h"
#include "bench/many/tally.h"
#include "bench/udp/one_way.h"
#include "bench/udp/paced_pair.h"

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
  std::optional<double> bound{};
  Tally tally{};

  template <class Measure>
  void run(const TwoHosts& hosts, Measure measure) {
    tally.add_ours(measure(one_way_times(sft_peer, paced, hosts)));
    tally.add_reference(measure(one_way_times(rival, paced, hosts)));
  }
  Figure figure() const { return tally.figure(name, "us", rival_name, bound); }
};

/// The processor time of a sample, summed over both sides.
struct CpuContest {
  std::string rate;
  Paced paced;
  Tally cyclone{}, raw{};

  void run(const TwoHosts& hosts) {
    const double ours = paced_cpu_us(sft_peer, paced, hosts);
    cyclone.add_ours(ours);
    raw.add_ours(ours);
    cyclone.add_reference(paced_cpu_us(cyclone_peer, paced, hosts));
    raw.add_reference(paced_cpu_us(raw_udp_peer, paced, hosts));
  }
  void figures(std::vector<Figure>& to) const {
    to.push_back(cyclone.figure("paced_cpu_" + rate, "us", "Cyclone DDS", 1));
    to.push_back(raw.figure("paced_cpu_" + rate + "_vs_raw_udp", "us", "raw UDP", {}));
  }
};

}  // namespace

std::vector<Figure> worst_large(const ManyScale& scale) {
  const TwoHosts hosts(Trains::whole);
  // The first tenth of 27 messages is not counted.
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
  const Paced at_10_hz{small, 50 / shortened, 100'000};
  const Paced at_100_hz{small, 300 / shortened, 10'000};
  const Paced at_1_khz{small, 2000 / shortened, 1000};
  const Paced of_16_kb{{.bulk_bytes = 16'000}, 300 / shortened, 10'000};
  std::array contests{Contest{"paced_64B_10Hz", at_10_hz, raw_udp_peer, "raw UDP", 1.3},
                      Contest{"paced_64B_10Hz_vs_cyclone", at_10_hz, cyclone_peer, "Cyclone DDS"},
                      Contest{"paced_64B_100Hz", at_100_hz, raw_udp_peer, "raw UDP", 1.3},
                      Contest{"paced_64B_100Hz_vs_cyclone", at_100_hz, cyclone_peer, "Cyclone DDS"},
                      Contest{"paced_64B_1kHz", at_1_khz, raw_udp_peer, "raw UDP", 1.3},
                      Contest{"paced_64B_1kHz_vs_cyclone", at_1_khz, cyclone_peer, "Cyclone DDS"},
                      Contest{"paced_16kB", of_16_kb, raw_tcp_peer, "TCP", 1.15},
                      Contest{"paced_16kB_vs_raw_udp", of_16_kb, raw_udp_peer, "raw UDP, GSO and GRO"}};
  std::array cpu_contests{CpuContest{"10Hz", at_10_hz}, CpuContest{"100Hz", at_100_hz},
                          CpuContest{"1kHz", at_1_khz}};
  for (int round = 0; round < scale.rounds; ++round) {
    for (Contest& contest : contests) contest.run(hosts, median_us);
    for (CpuContest& contest : cpu_contests) contest.run(hosts);
  }
  std::vector<Figure> figures;
  for (const Contest& contest : contests) figures.push_back(contest.figure());
  for (const CpuContest& contest : cpu_contests) contest.figures(figures);
  return figures;
}

}  // namespace sft::bench
