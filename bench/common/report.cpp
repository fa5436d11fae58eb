#include "bench/common/report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <ostream>

namespace sft::bench {

void print_table(const std::vector<Figure>& figures) {
  const bool worst = std::ranges::any_of(figures, [](const Figure& f) { return f.worst.has_value(); });
  const auto number = [](const char* format, const std::optional<double>& value) {
    return value ? fmt::format(fmt::runtime(format), *value) : "";
  };
  std::size_t name_width = 36;
  for (const Figure& figure : figures) name_width = std::max(name_width, figure.name.size());
  const auto row = [&](const std::string& name, const auto&... columns) {
    fmt::print("{:<{}} {:>12} {:<6} {:>12} {:<34} {:>7} {:>14}", name, name_width, columns...);
  };
  row("figure", "value", "unit", "reference", "of", "ratio", "bound");
  fmt::print("{}\n", worst ? fmt::format(" {:>12}", "worst round") : "");
  for (const Figure& f : figures) {
    const std::string ratio = f.reference ? fmt::format("{:.2f}", f.measure()) : "";
    const std::string bound = f.bound ? fmt::format("{}{} {:.4g}", f.within_bound() ? "" : "MISSES ",
                                                    f.at_least ? ">=" : "<=", *f.bound)
                                      : "";
    row(f.name, fmt::format("{:.3f}", f.value), f.unit, number("{:.3f}", f.reference), f.reference_name,
        ratio, bound);
    fmt::print("{}\n", worst ? fmt::format(" {:>12}", number("{:.3f}", f.worst)) : "");
  }
  std::fflush(stdout);
}

void print_missed_bounds(const std::vector<Figure>& figures) {
  std::vector<std::string> missed;
  for (const Figure& f : figures) {
    if (!f.within_bound()) missed.push_back(f.name);
  }
  const bool bounds = std::ranges::any_of(figures, [](const Figure& f) { return f.bound.has_value(); });
  if (!missed.empty()) {
    fmt::print("These bounds do not hold: {}.\n", fmt::join(missed, ", "));
  } else if (bounds) {
    fmt::print("All bounds hold.\n");
  }
  std::fflush(stdout);
}

void write_json(std::ostream& out, const std::vector<Figure>& figures) {
  nlohmann::json list = nlohmann::json::array();
  for (const Figure& f : figures) {
    nlohmann::json entry{{"name", f.name}, {"value", f.value}, {"unit", f.unit}};
    entry["reference"] = f.reference ? nlohmann::json(*f.reference) : nlohmann::json();
    entry["ratio"] = f.reference ? nlohmann::json(f.measure()) : nlohmann::json();
    if (f.reference && !f.reference_name.empty()) entry["reference_name"] = f.reference_name;
    if (f.bound) {
      entry["bound"] = *f.bound;
      entry["bound_of"] = f.reference && !f.bound_is_of_value ? "ratio" : "value";
      if (f.at_least) entry["at_least"] = true;
    }
    if (f.worst) entry["worst"] = *f.worst;
    list.push_back(std::move(entry));
  }
  out << list.dump(2) << std::endl;
}

}  // namespace sft::bench
