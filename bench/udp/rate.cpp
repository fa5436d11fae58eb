#include "bench/udp/stream.h"
#include "bench/udp/udp.h"

namespace sft::bench {

namespace {

constexpr std::uint32_t depth = 4000;
constexpr std::uint64_t together = 100;

Figure rate_figure(const char* name, const StreamRounds& ours, const StreamRounds& than, const char* who,
                   std::optional<double> bound, bool bound_is_of_value = false) {
  return {.name = name,
          .value = ours.samples_per_s() / 1000,
          .unit = "k/s",
          .reference = than.samples_per_s() / 1000,
          .reference_name = who,
          .bound = bound,
          .bound_is_of_value = bound_is_of_value,
          .at_least = true};
}

}  // namespace

std::vector<Figure> rate(const Scale& scale) {
  const TwoHosts hosts(Trains::whole);
  const Load single{.topic = {.depth = depth}, .seconds = scale.seconds};
  Load spans = single;
  spans.topic.batching = true;
  spans.together = together;
  StreamRounds ours, raw, cyclone, fast_dds, ours_span, cyclone_batches;
  for (int round = 0; round < scale.rounds; ++round) {
    ours.run(sft_peer, single, hosts);
    raw.run(raw_udp_peer, single, hosts);
    cyclone.run(cyclone_peer, single, hosts);
    fast_dds.run(fast_dds_peer, single, hosts);
    ours_span.run(sft_peer, spans, hosts);
    cyclone_batches.run(cyclone_peer, spans, hosts);
  }
  return {rate_figure("rate_64B", ours, cyclone, "Cyclone DDS", 2),
          rate_figure("rate_64B_vs_fast_dds", ours, fast_dds, "Fast DDS", 1),
          rate_figure("rate_64B_vs_raw", ours, raw, "a system call for each datagram", {}),
          {"rate_64B_lost", ours.lost(), "", {}, "of all samples published", 0},
          rate_figure("rate_64B_span", ours_span, cyclone_batches, "Cyclone DDS, write batching", 3000, true),
          {"rate_64B_span_lost", ours_span.lost(), "", {}, "of all samples published", 0}};
}

}  // namespace sft::bench
