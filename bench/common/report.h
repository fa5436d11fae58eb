// The results of a benchmark, as a table for people and as JSON for programs.
#pragma once

#include <iosfwd>
#include <optional>
#include <string>
#include <vector>

namespace sft::bench {

struct Figure {
  std::string name;
  double value = 0;
  std::string unit{};
  std::optional<double> reference{};  ///< the value of the reference in the same run and unit
  std::string reference_name{};
  std::optional<double> bound{};   ///< the limit of the ratio, or of the value if there is no reference
  bool bound_is_of_value = false;  ///< true: `bound` limits the value, although there is a reference
  bool at_least = false;           ///< true: `bound` is a minimum and not a maximum
  std::optional<double> worst{};   ///< the value of the worst round

  double measure() const { return reference ? value / *reference : value; }
  bool within_bound() const {
    if (!bound) return true;
    const double bounded = bound_is_of_value ? value : measure();
    return at_least ? bounded >= *bound : bounded <= *bound;
  }
};

/// Prints a table, with a column for the worst rounds if there are any.
void print_table(const std::vector<Figure>& figures);
/// Prints the bounds that are exceeded, or prints that none is exceeded. Prints nothing if there are no
/// bounds.
void print_missed_bounds(const std::vector<Figure>& figures);

/// Writes a list of {"name", "value", "unit", "reference", "ratio"}. Figures with a bound also have
/// "bound", "bound_of" with the value "ratio" or "value", and "at_least" if the bound is a minimum. Figures
/// of several rounds also have the value of the "worst" round.
void write_json(std::ostream& out, const std::vector<Figure>& figures);

}  // namespace sft::bench
