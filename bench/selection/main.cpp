// Measures selections: the time to take and read parts of fields and to evaluate conditions, and the costs
// between hosts.
#include "bench/common/program.h"
#include "bench/selection/selection.h"
#include "tests/support/isolated_host.h"

int main(int argc, char** argv) {
  using namespace sft::bench;
  int rounds = 100;
  std::uint64_t samples = 100;
  std::uint64_t moves = 300;
  int pairs = 3;
  Program program("Time of taking parts of fields and of conditions, and what they cost between hosts",
                  {{"gathering", [&] { return gathering_parts(rounds); }},
                   {"points", [&] { return reading_points(rounds); }},
                   {"gates", [&] { return closed_gates(rounds); }},
                   {"between_hosts", [&] { return parts_between_hosts(samples, pairs); }},
                   {"beside", [&] { return beside_narrow_topics_and_compression(samples / 2, pairs); }},
                   {"window_move", [&] { return moved_windows(moves, pairs); }}});
  program.options()
      .add_option("--rounds", rounds, "rounds of each contender, in turns; the best counts")
      ->check(CLI::Range(1, 100'000));
  program.options()
      .add_option("--samples", samples, "samples between hosts in each round, at 20 Hz")
      ->check(CLI::Range(10, 10'000));
  program.options()
      .add_option("--moves", moves, "moves of a window between hosts in each round")
      ->check(CLI::Range(10, 10'000));
  program.options()
      .add_option("--host-rounds", pairs, "rounds between hosts, in turns; the median counts")
      ->check(CLI::Range(1, 100));
  if (const auto code = program.parse(argc, argv)) return *code;
  return sft::test::run_isolated([&] { return program.run(); });
}
