// What a benchmark found: a table for people and, if asked for, JSON for programs.
#pragma once

#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

namespace sft::bench {

struct Figure {
  std::string name;
  double value = 0;
  std::string unit;
  std::optional<double> reference{};  ///< measured in the same run, same unit
  std::string reference_name{};
  std::optional<double> bound{};   ///< of the ratio, or of the value where there is no reference
  bool bound_is_of_value = false;  ///< although there is one
  bool at_least = false;           ///< the bound; otherwise at most

  double measure() const { return reference ? value / *reference : value; }
  bool within_bound() const {
    if (!bound) return true;
    const double bounded = bound_is_of_value ? value : measure();
    return at_least ? bounded >= *bound : bounded <= *bound;
  }
};

void print_table(const std::vector<Figure>& figures);

/// A list of {"name", "value", "unit", "reference", "ratio"}.
void write_json(std::ostream& out, const std::vector<Figure>& figures);

}  // namespace sft::bench
