// Measures the median time from publish to callback of small samples between two hosts that sleep in between,
// and their processor time.
#include <array>
#include <optional>
#include <string>

#include "bench/common/statistics.h"
#include "bench/many/many.h"
#include "bench/many/tally.h"
#include "bench/udp/one_way.h"
#include "bench/udp/paced_pair.h"

namespace sft::bench {

namespace {

struct Contest {
  const char* name;
  Paced paced;
  Contender rival;
  const char* rival_name;
  std::optional<double> bound{};
  Tally tally{};

  void run(const TwoHosts& hosts) {
    tally.add_ours(median_if_any(one_way_times(sft_peer, paced, hosts)));
    tally.add_reference(median_if_any(one_way_times(rival, paced, hosts)));
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
    for (Contest& contest : contests) contest.run(hosts);
    for (CpuContest& contest : cpu_contests) contest.run(hosts);
  }
  std::vector<Figure> figures;
  for (const Contest& contest : contests) figures.push_back(contest.figure());
  for (const CpuContest& contest : cpu_contests) contest.figures(figures);
  return figures;
}

}  // namespace sft::bench
