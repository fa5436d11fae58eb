// What the type support costs: encoding, reading, gathering and generated code, on one core, each in turns
// with its references.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <fstream>

#include "bench/common/pair.h"
#include "bench/typesupport/typesupport.h"

namespace {

using namespace sft::bench;

int run(int rounds, const std::string& only, std::ofstream& json) {
  std::vector<Figure> figures;
  const auto add = [&](const char* group, auto measure) {
    if (!only.empty() && only != group) return;
    fmt::print(stderr, "measuring {} ...\n", group);
    for (Figure& f : measure()) figures.push_back(std::move(f));
  };
  add("encoding", [&] { return encoding(rounds); });
  add("decoding", [&] { return decoding(rounds); });
  add("gathering", [&] { return gathering(rounds); });
  add("generated", [] { return generated_code(); });
  print_table(figures);
  if (json.is_open()) write_json(json, figures);
  return json.fail() ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Time of encoding, reading and gathering messages, and size of generated code"};
  int rounds = 500;
  std::string json;
  std::string only;
  app.add_option("--json", json, "also write the figures to this file");
  app.add_option("--rounds", rounds, "of each contender, in turns; the best counts")
      ->check(CLI::Range(1, 100'000));
  app.add_option("--only", only, "one group")
      ->check(CLI::IsMember({"encoding", "decoding", "gathering", "generated"}));
  CLI11_PARSE(app, argc, argv);
  std::ofstream file;
  if (!json.empty()) file.open(json);
  if (file.fail()) {
    fmt::print(stderr, "bench_typesupport: {} cannot be written\n", json);
    return 1;
  }
  pin_to_core(1);
  return run(rounds, only, file);
}
