// Measures the type support on one core, in turns with its references: encoding, reading, gathering.
#include "bench/common/process.h"
#include "bench/common/program.h"
#include "bench/typesupport/typesupport.h"

int main(int argc, char** argv) {
  using namespace sft::bench;
  int rounds = 500;
  Program program("Time of encoding, reading and gathering messages",
                  {{"encoding", [&] { return encoding(rounds); }},
                   {"decoding", [&] { return decoding(rounds); }},
                   {"gathering", [&] { return gathering(rounds); }}});
  program.options()
      .add_option("--rounds", rounds, "rounds of each contender, in turns; the best counts")
      ->check(CLI::Range(1, 100'000));
  if (const auto code = program.parse(argc, argv)) return *code;
  pin_to_core(1);
  return program.run();
}
