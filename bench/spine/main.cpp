// The spine in figures: latency in shared memory and over UDP, bytes on the wire, response of the
// negotiation. Every latency is measured with both sides pinned to a core of their own, in turns with its
// reference.
#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <fstream>

#include "bench/spine/spine.h"
#include "tests/support/isolated_host.h"

namespace {

using namespace sft::bench;

int run(const Scale& scale, const std::string& only, std::ofstream& json) {
  std::vector<Figure> figures;
  const auto add = [&](const char* group, auto measure) {
    if (!only.empty() && only != group) return;
    fmt::print(stderr, "measuring {} ...\n", group);
    for (Figure& f : measure()) figures.push_back(std::move(f));
  };
  add("shm", [&] { return shared_memory(scale); });
  add("udp", [&] { return udp_small(scale); });
  add("str", [&] { return str_response(scale); });
  add("wire", [] { return wire_bytes(); });
  print_table(figures);
  if (json.is_open()) write_json(json, figures);
  return json.fail() ? 1 : 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Latency, wire bytes and response of the spine, against references of the same run"};
  Scale scale;
  std::string json;
  std::string only;
  app.add_option("--json", json, "also write the figures to this file");
  app.add_option("--messages", scale.messages, "per round and contender")->check(CLI::Range(100, 20'000));
  app.add_option("--rounds", scale.rounds, "of each contender")->check(CLI::Range(1, 100));
  app.add_option("--only", only, "one group")->check(CLI::IsMember({"shm", "udp", "str", "wire"}));
  CLI11_PARSE(app, argc, argv);
  std::ofstream file;  // opened here, since the run has a /tmp of its own
  if (!json.empty()) file.open(json);
  if (file.fail()) {
    fmt::print(stderr, "bench_spine: {} cannot be written\n", json);
    return 1;
  }
  return sft::test::run_isolated([&] { return run(scale, only, file); });
}
