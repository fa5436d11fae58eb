// Measures large samples by UDP where SFT has less help than usual.
#include "bench/many/many.h"
#include "bench/many/tally.h"
#include "bench/udp/stream.h"

namespace sft::bench {

namespace {

constexpr std::uint32_t large = 4 << 20;

struct Stream {
  double gb_per_s;
  double cpu_s_per_gb;
};

Stream stream(Contender contender, std::uint32_t bytes, double seconds, const TwoHosts& hosts) {
  StreamRounds one;
  one.run(contender, {.topic = {.bulk_bytes = bytes}, .seconds = seconds}, hosts);
  const double gb = bytes / 1e9;
  return {one.samples_per_s() * gb, one.cpu_s_per_sample() / gb};
}

double seconds_of(const ManyScale& scale) { return scale.quick ? 0.5 : 1; }

}  // namespace

std::vector<Figure> bulk_without(const ManyScale& scale) {
  const TwoHosts bare(Trains::none), usual(Trains::whole);
  const double seconds = seconds_of(scale);
  Tally rate, cpu, rate_of_raw, cpu_of_raw, small_buffer;
  for (int round = 0; round < scale.rounds; ++round) {
    const Stream ours = stream(sft_peer, large, seconds, bare);
    const Stream tcp = stream(raw_tcp_peer, large, seconds, bare);
    rate.add_ours(ours.gb_per_s);
    rate.add_reference(tcp.gb_per_s);
    cpu.add_ours(ours.cpu_s_per_gb);
    cpu.add_reference(tcp.cpu_s_per_gb);
    const Stream raw = stream(raw_udp_peer, large, seconds, bare);  // the costs of plain datagrams
    rate_of_raw.add_ours(ours.gb_per_s);
    rate_of_raw.add_reference(raw.gb_per_s);
    cpu_of_raw.add_ours(ours.cpu_s_per_gb);
    cpu_of_raw.add_reference(raw.cpu_s_per_gb);
    small_buffer.add_ours(stream(sft_small_buffer_peer, large, seconds, usual).gb_per_s);
    small_buffer.add_reference(stream(raw_tcp_peer, large, seconds, usual).gb_per_s);
  }
  return {rate.figure("bulk_no_offload", "GB/s", "TCP", 1, true),
          cpu.figure("bulk_no_offload_cpu", "s/GB", "TCP", 1.3),
          rate_of_raw.figure("bulk_no_offload_vs_raw_udp", "GB/s", "raw UDP", {}, true),
          cpu_of_raw.figure("bulk_no_offload_cpu_vs_raw_udp", "s/GB", "raw UDP", {}),
          small_buffer.figure("bulk_small_buffer", "GB/s", "TCP", 1, true)};
}

}  // namespace sft::bench
