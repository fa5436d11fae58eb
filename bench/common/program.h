// The main program of each benchmark. It measures all groups of figures, or one chosen group. It prints a
// table and the noise of the machine, and writes both to a file.
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
  /// Makes a program that measures `groups` in this order.
  Program(const std::string& description, std::vector<Group> groups);

  /// Returns the options of the benchmark, to which a benchmark can add options of its own. The options
  /// include --json and --only.
  CLI::App& options() { return options_; }

  /// Leaves out the table. Used by a benchmark whose groups print tables of their own.
  void leave_out_table() { has_table_ = false; }

  /// Reads the command line. Returns the exit code if the program must end at once. The file for the
  /// figures is opened here, since an isolated run has its own /tmp.
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
