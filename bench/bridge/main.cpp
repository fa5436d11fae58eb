// Measures `sft bridge`, with a bridge on a robot, another one at a station, and a radio link of 50 Mbit/s
// between them that loses 1 % of all packets. Hosts are network namespaces with an MTU of 1500.
#include "bench/bridge/bridge.h"
#include "bench/common/program.h"
#include "tests/support/isolated_host.h"

int main(int argc, char** argv) {
  using namespace sft::bench;
  constexpr unsigned shm_mebibytes = 1024;  // enough for all of sftd's default memory, as on a usual robot
  BridgeScale scale;
  Program program(
      "Samples through two bridges on a bad link, and what bridges cost",
      {{"carrying", [&] { return bridge_carrying(scale); }}, {"idle", [&] { return bridge_idle(scale); }}});
  program.options()
      .add_option("--rounds", scale.rounds, "rounds with and without bridges")
      ->check(CLI::Range(1, 20));
  program.options()
      .add_option("--seconds", scale.seconds, "duration of each part of a round")
      ->check(CLI::Range(1., 60.));
  if (const auto code = program.parse(argc, argv)) return *code;
  return sft::test::run_isolated([&] {
    const sft::test::ShmOfSize memory(shm_mebibytes);
    return program.run();
  });
}
