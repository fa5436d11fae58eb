// Measures the negotiation: how soon a reader gets the fields that it requests, and the costs for its
// publisher. Two network namespaces are the hosts, and each side has its own core.
#include "bench/common/program.h"
#include "bench/negotiation/negotiation.h"
#include "tests/support/isolated_host.h"

int main(int argc, char** argv) {
  using namespace sft::bench;
  Scale scale;
  Program program("Speed and cost of the negotiation, against references of the same run",
                  {
                      {"response", [&] { return str_response(scale); }},
                      {"new_nodes", [&] { return first_sample_new_nodes(scale); }},
                      {"late_reader", [&] { return first_sample_late_reader(scale); }},
                  });
  program.options()
      .add_option("--messages", scale.messages, "messages per round and contender")
      ->check(CLI::Range(100, 20'000));
  program.options()
      .add_option("--rounds", scale.rounds, "rounds of each contender")
      ->check(CLI::Range(1, 100));
  if (const auto code = program.parse(argc, argv)) return *code;
  return sft::test::run_isolated([&] { return program.run(); });
}
