// Measures for how long hostile programs and faults disturb other programs after their end; see
// tests/hostile.
#include "bench/common/program.h"
#include "bench/recovery/recovery.h"
#include "tests/support/isolated_host.h"

int main(int argc, char** argv) {
  using namespace sft::bench;
  RecoveryScale scale;
  Program program("Time from the end of a hostile act until every pair is served as before",
                  {{"recovery", [&] { return recovery_after_each_act(scale); }}});
  program.options().add_option("--rounds", scale.rounds, "rounds of each act")->check(CLI::Range(1, 1000));
  program.options().add_option("--act", scale.act,
                               "perform this act only; hostile_actor --list names the acts");
  program.options().add_option("--seed", scale.seed, "the seed of all random numbers");
  if (const auto code = program.parse(argc, argv)) return *code;
  return sft::test::run_isolated([&] { return program.run(); });
}
