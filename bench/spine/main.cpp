// Measures the basic path of a sample: latency in shared memory and by UDP, and bytes on the wire. For
// latency, each side is pinned to its own core, and SFT and its reference run in turns.
#include "bench/common/program.h"
#include "bench/spine/spine.h"
#include "tests/support/isolated_host.h"

int main(int argc, char** argv) {
  using namespace sft::bench;
  Scale scale;
  Program program("Latency and wire bytes of the spine, against references of the same run",
                  {{"shm", [&] { return shared_memory(scale); }},
                   {"udp", [&] { return udp_small(scale); }},
                   {"wire", [] { return wire_bytes(); }}});
  program.options()
      .add_option("--messages", scale.messages, "messages per round and contender")
      ->check(CLI::Range(100, 20'000));
  program.options()
      .add_option("--rounds", scale.rounds, "rounds of each contender")
      ->check(CLI::Range(1, 100));
  if (const auto code = program.parse(argc, argv)) return *code;
  return sft::test::run_isolated([&] { return program.run(); });
}
