// Measures UDP between hosts: throughput, latency and bytes, compared with Cyclone DDS, Fast DDS and raw
// sockets in the same run. Each side is pinned to its own core. The hosts are network namespaces with an MTU
// of 1500.
#include "bench/common/pair.h"
#include "bench/common/program.h"
#include "bench/udp/udp.h"
#include "tests/support/isolated_host.h"

int main(int argc, char** argv) {
  using namespace sft::bench;
  Scale scale;
  Program program("Speed and bytes of UDP between hosts, against references of the same run",
                  {{"bulk", [&] { return bulk(scale); }},
                   {"small", [&] { return small(scale); }},
                   {"cold_path", [&] { return cold_path(scale); }},
                   {"rate", [&] { return rate(scale); }},
                   {"wire_overhead", [&] { return wire_overhead(scale); }},
                   {"diagnostic", [] { return diagnostic_bytes(); }}});
  program.options()
      .add_option("--messages", scale.messages, "messages of 64 bytes per round and contender")
      ->check(CLI::Range(std::size_t{100}, Exchange::samples_max));
  program.options()
      .add_option("--rounds", scale.rounds, "rounds of each contender")
      ->check(CLI::Range(1, 100));
  program.options()
      .add_option("--seconds", scale.seconds, "seconds for which a stream of samples is measured")
      ->check(CLI::Range(0.1, 100.));
  if (const auto code = program.parse(argc, argv)) return *code;
  return sft::test::run_isolated([&] { return program.run(); });
}
