#include "bench/common/program.h"

#include <fmt/format.h>

#include <utility>

namespace sft::bench {

Program::Program(const std::string& description, std::vector<Group> groups)
    : options_(description), groups_(std::move(groups)) {
  std::vector<std::string> names;
  for (const Group& group : groups_) names.push_back(group.name);
  options_.add_option("--json", json_, "also write the figures as JSON to this file");
  options_.add_option("--only", only_, "one group")->check(CLI::IsMember(names));
}

std::optional<int> Program::parse(int argc, char** argv) {
  try {
    options_.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return options_.exit(error);
  }
  if (!json_.empty()) file_.open(json_);
  if (!file_.fail()) return std::nullopt;
  fmt::print(stderr, "cannot write {}\n", json_);
  return 1;
}

int Program::run() {
  std::vector<Figure> figures;
  for (const Group& group : groups_) {
    if (!only_.empty() && only_ != group.name) continue;
    fmt::print(stderr, "measuring {} ...\n", group.name);
    for (Figure& figure : group.measure()) figures.push_back(std::move(figure));
  }
  print_table(figures);
  if (file_.is_open()) write_json(file_, figures);
  return file_.fail() ? 1 : 0;
}

}  // namespace sft::bench
