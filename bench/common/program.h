// What the programs of all benchmarks do: measure their groups of figures, or the one that is asked for,
// print a table and write the figures to a file.
#pragma once

#include <CLI/CLI.hpp>
#include <fstream>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bench/common/report.h"

namespace sft::bench {

struct Group {
  std::string name;
  std::function<std::vector<Figure>()> measure;
};

class Program {
 public:
  /// `groups` are measured in this order.
  Program(const std::string& description, std::vector<Group> groups);

  /// For options of the benchmark's own, beside --json and --only.
  CLI::App& options() { return options_; }

  /// The exit code, if the program is to end at once. What it is to write is opened here: a run that is
  /// isolated has a /tmp of its own.
  std::optional<int> parse(int argc, char** argv);
  /// Returns the exit code.
  int run();

 private:
  CLI::App options_;
  std::vector<Group> groups_;
  std::string only_;
  std::string json_;
  std::ofstream file_;
};

}  // namespace sft::bench
