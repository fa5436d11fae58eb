// The main program of each benchmark. It measures its groups of figures, or a chosen group. It prints a table
// and the noise of the machine, and writes both to a file.
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
  /// Measures `groups` in this order.
  Program(const std::string& description, std::vector<Group> groups);

  /// The options of the benchmark, besides --json and --only.
  CLI::App& options() { return options_; }

  /// Prints no table. For a benchmark whose groups print tables of their own.
  void leave_out_table() { has_table_ = false; }

  /// Returns the exit code if the program must end at once. Opens the file for the figures already here,
  /// since an isolated run has its own /tmp.
  std::optional<int> parse(int argc, char** argv);
  /// Runs the benchmark and returns the exit code.
  int run();

 private:
  bool is_chosen(const Group& group) const;

  CLI::App options_;
  std::vector<Group> groups_;
  std::vector<std::string> only_;
  std::string json_;
  bool has_table_ = true;
  std::ofstream file_;
};

}  // namespace sft::bench
