#include "bench/common/program.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <iterator>
#include <utility>

#include "bench/common/noise.h"

namespace sft::bench {

Program::Program(const std::string& description, std::vector<Group> groups)
    : options_(description), groups_(std::move(groups)) {
  std::vector<std::string> names;
  for (const Group& group : groups_) names.push_back(group.name);
  options_.add_option("--json", json_, "also write the figures as JSON to this file");
  options_.add_option("--only", only_, "these groups only: NAME,NAME")
      ->delimiter(',')
      ->allow_extra_args(false)
      ->check(CLI::IsMember(names));
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

bool Program::is_chosen(const Group& group) const {
  return only_.empty() || std::ranges::find(only_, group.name) != only_.end();
}

int Program::run() {
  const Noise noise;
  std::vector<Figure> figures;
  for (const Group& group : groups_) {
    if (!is_chosen(group)) continue;
    fmt::print(stderr, "measuring {} ...\n", group.name);
    const auto begin = std::chrono::steady_clock::now();
    std::ranges::move(group.measure(), std::back_inserter(figures));
    const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
    fmt::print(stderr, "{} took {:.0f} s\n", group.name, took.count());
  }
  if (has_table_) print_table(figures);
  print_missed_bounds(figures);
  const Noise::Shares shares = noise.shares();
  fmt::print("{}\n", text_of(shares));
  std::fflush(stdout);
  std::ranges::move(figures_of(shares), std::back_inserter(figures));
  if (file_.is_open()) write_json(file_, figures);
  return file_.fail() ? 1 : 0;
}

}  // namespace sft::bench
