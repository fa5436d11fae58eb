// Measures shared memory: latency and fan-out. Every side is pinned to a core. SFT and
// the references run in turns, with messages of the same size.
#include "bench/common/pair.h"
#include "bench/common/program.h"
#include "bench/shm/shm.h"
#include "tests/support/isolated_host.h"

int main(int argc, char** argv) {
  using namespace sft::bench;
  Scale scale;
  Program program("Speed of shared memory, against references of the same run",
                  {{"hand_over", [&] { return hand_over(scale); }},
                   {"fan_out", [&] { return fan_out(scale); }},
                   {"size_flatness", [&] { return size_flatness(scale); }}});
  program.options()
      .add_option("--messages", scale.messages, "messages per round and contender")
      ->check(CLI::Range(std::size_t{100}, Exchange::samples_max));
  program.options()
      .add_option("--rounds", scale.rounds, "rounds of each contender")
      ->check(CLI::Range(1, 100));
  if (const auto code = program.parse(argc, argv)) return *code;
  return sft::test::run_isolated([&] { return program.run(); });
}
