// Measures the Python package, recordings and `sft perf`, compared with programs that do only what is
// necessary. All programs run on one host.
#include <cstdlib>

#include "bench/common/program.h"
#include "bench/tools/tools.h"
#include "tests/support/isolated_host.h"

int main(int argc, char** argv) {
  using namespace sft::bench;
  Scale scale;
  Program program("Speed of Python, recordings and sft perf, against references of the same run",
                  {{"python", [&] { return python(scale); }},
                   {"record", [&] { return record(scale); }},
                   {"play", [&] { return play(scale); }},
                   {"perf", [&] { return perf(scale); }}});
  program.options().add_option("--rounds", scale.rounds, "rounds of each program")->check(CLI::Range(1, 100));
  program.options()
      .add_option("--seconds", scale.seconds, "duration of a round of most programs")
      ->check(CLI::Range(0.5, 60.));
  if (const auto code = program.parse(argc, argv)) return *code;
  setenv("TMPDIR", sft::test::program_directory().c_str(), 0);  // /tmp may be no disk
  return sft::test::run_isolated([&] { return program.run(); });
}
