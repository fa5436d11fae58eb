#include "bench/udp/stream.h"
#include "bench/udp/udp.h"

namespace sft::bench {

namespace {

constexpr std::uint32_t data_bytes = 4 << 20;

double gb_per_s(const StreamRounds& rounds) { return rounds.samples_per_s() * data_bytes / 1e9; }
double cpu_s_per_gb(const StreamRounds& rounds) { return rounds.cpu_s_per_sample() / (data_bytes / 1e9); }

}  // namespace

std::vector<Figure> bulk(const Scale& scale) {
  const TwoHosts hosts(Trains::whole);
  const Load load{.topic = {.bulk_bytes = data_bytes}, .seconds = scale.seconds};
  StreamRounds ours, loaned, raw, raw_copying, cyclone, fast_dds;
  for (int round = 0; round < scale.rounds; ++round) {
    ours.run(sft_peer, load, hosts);
    loaned.run(sft_loan_peer, load, hosts);
    raw.run(raw_udp_peer, load, hosts);
    raw_copying.run(raw_udp_copying_peer, load, hosts);
    cyclone.run(cyclone_peer, load, hosts);
    fast_dds.run(fast_dds_peer, load, hosts);
  }
  const auto faster = [&](const char* name, const StreamRounds& figure, const StreamRounds& than,
                          const char* who, std::optional<double> times) {
    return Figure{.name = name,
                  .value = gb_per_s(figure),
                  .unit = "GB/s",
                  .reference = gb_per_s(than),
                  .reference_name = who,
                  .bound = times,
                  .at_least = true};
  };
  const auto cheaper = [&](const char* name, const StreamRounds& than, const char* who,
                           std::optional<double> ratio) {
    return Figure{.name = name,
                  .value = cpu_s_per_gb(ours),
                  .unit = "s/GB",
                  .reference = cpu_s_per_gb(than),
                  .reference_name = who,
                  .bound = ratio};
  };
  return {faster("bulk_4MiB_reliable", ours, raw, "raw UDP with GSO and GRO", 0.6),
          faster("bulk_4MiB_reliable_vs_copying", ours, raw_copying, "the same after a memcpy", {}),
          faster("bulk_4MiB_reliable_loan", loaned, raw, "raw UDP with GSO and GRO", 0.6),
          faster("bulk_4MiB_loan_vs_publish", loaned, ours, "publish(message)", 1 / 1.05),
          faster("bulk_4MiB_vs_cyclone", ours, cyclone, "Cyclone DDS", 5),
          faster("bulk_4MiB_vs_fast_dds", ours, fast_dds, "Fast DDS", 5),
          faster("bulk_4MiB_loan_vs_cyclone", loaned, cyclone, "Cyclone DDS", 5),
          faster("bulk_4MiB_loan_vs_fast_dds", loaned, fast_dds, "Fast DDS", 5),
          {"bulk_4MiB_lost", ours.lost() + loaned.lost(), "", {}, "of all samples published", 0},
          cheaper("cpu_per_GB", raw, "raw UDP with GSO and GRO", {}),
          cheaper("cpu_per_GB_vs_cyclone", cyclone, "Cyclone DDS", 1. / 3),
          cheaper("cpu_per_GB_vs_fast_dds", fast_dds, "Fast DDS", 1. / 3)};
}

}  // namespace sft::bench
