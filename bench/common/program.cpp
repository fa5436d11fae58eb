#include "bench/common/program.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <utility>

#include "bench/common/noise.h"

namespace sft::bench {

Program::Program(const std::string& description, std::vector<Group> groups)
    : options_(description), groups_(std::move(groups)) {
  std::vector<std::string> names;
  for (const Group& group : groups_) {
    names.push_back(group.name);
    std::ranges::copy_if(group.figures, std::back_inserter(names),
                         [&](const std::string& figure) { return figure != group.name; });
  }
  options_.add_option("--json", json_, "also write the figures as JSON to this file");
  options_.add_option("--only", only_, "these groups, or figures, only: NAME,NAME")
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

bool Program::chosen(const std::string& name) const {
  return only_.empty() || std::ranges::find(only_, name) != only_.end();
}

bool Program::is_chosen(const Group& group) const {
  return chosen(group.name) ||
         std::ranges::any_of(group.figures, [&](const std::string& figure) { return chosen(figure); });
}

void Program::measure(const Group& group, std::vector<Figure>& to) const {
  if (!is_chosen(group)) return;
  const bool all = chosen(group.name);
  fmt::print(stderr, "measuring {} ...\n", group.name);
  for (Figure& figure : group.measure()) {
    if (all || chosen(figure.name)) to.push_back(std::move(figure));
  }
}

int Program::run() {
  const Noise noise;
  std::vector<Figure> figures;
  for (const Group& group : groups_) measure(group, figures);
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
