// Measures shared memory: latency, fan-out, and the cost of waiting. Every side is pinned to a core. SFT and
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
                   {"messages", [&] { return messages(scale); }},
                   {"fan_out", [&] { return fan_out(scale); }},
                   {"clouds", [&] { return clouds(scale); }},
                   {"size_flatness", [&] { return size_flatness(scale); }},
                   {"idle_cpu", [&] { return idle_cpu(scale); }}});
  program.options()
      .add_option("--messages", scale.messages, "messages per round and contender")
      ->check(CLI::Range(std::size_t{100}, Exchange::samples_max));
  program.options()
      .add_option("--rounds", scale.rounds, "rounds of each contender")
      ->check(CLI::Range(1, 100));
  program.options()
      .add_option("--idle-seconds", scale.idle_s, "seconds for which a waiting node is measured")
      ->check(CLI::Range(0.1, 100.));
  if (const auto code = program.parse(argc, argv)) return *code;
  return sft::test::run_isolated([&] { return program.run(); });
}
