// Measures the costs of communication with nodes of plain DDS, compared with Cyclone DDS alone. Also
// measures that such nodes cost other readers nothing.
#include "bench/common/program.h"
#include "bench/vanilla/vanilla.h"
#include "tests/support/isolated_host.h"

int main(int argc, char** argv) {
  using namespace sft::bench;
  VanillaScale scale;
  Program program("Costs of unmodified DDS nodes, against Cyclone DDS alone and against SFT without them",
                  {{"write", [&] { return vanilla_write(scale); }},
                   {"read", [&] { return vanilla_read(scale); }},
                   {"first_sample", [&] { return vanilla_first_sample(scale); }},
                   {"stopped", [&] { return local_beside_stopped_vanilla(scale); }},
                   {"bytes", [&] { return bytes_to_sft_readers(scale); }},
                   {"idle", [&] { return idle_without_vanilla(scale); }}});
  program.options().add_option("--rounds", scale.rounds, "rounds of each program")->check(CLI::Range(1, 100));
  program.options()
      .add_option("--samples", scale.samples, "samples per round and program")
      ->check(CLI::Range(10, 10'000));
  program.options().add_option("--starts", scale.starts, "starts of readers, for each program");
  program.options()
      .add_option("--idle-seconds", scale.idle_s, "the time in which idle nodes are measured")
      ->check(CLI::Range(1., 300.));
  if (const auto code = program.parse(argc, argv)) return *code;
  return sft::test::run_isolated([&] { return program.run(); });
}
