#include "bench/common/report.h"

#include <fmt/format.h>

#include <cstdio>
#include <nlohmann/json.hpp>
#include <ostream>

namespace sft::bench {

void print_table(const std::vector<Figure>& figures) {
  fmt::print("{:<36} {:>12} {:<6} {:>12} {:<34} {:>7} {:>14}\n", "figure", "value", "unit", "reference", "of",
             "ratio", "bound");
  for (const Figure& f : figures) {
    const std::string reference = f.reference ? fmt::format("{:.3f}", *f.reference) : "";
    const std::string ratio = f.reference ? fmt::format("{:.2f}", f.measure()) : "";
    const std::string bound = f.bound ? fmt::format("{}{} {:.4g}", f.within_bound() ? "" : "MISSES ",
                                                    f.at_least ? ">=" : "<=", *f.bound)
                                      : "";
    fmt::print("{:<36} {:>12.3f} {:<6} {:>12} {:<34} {:>7} {:>14}\n", f.name, f.value, f.unit, reference,
               f.reference_name, ratio, bound);
  }
  std::fflush(stdout);
}

void write_json(std::ostream& out, const std::vector<Figure>& figures) {
  nlohmann::json list = nlohmann::json::array();
  for (const Figure& f : figures) {
    nlohmann::json entry{{"name", f.name}, {"value", f.value}, {"unit", f.unit}};
    entry["reference"] = f.reference ? nlohmann::json(*f.reference) : nlohmann::json();
    entry["ratio"] = f.reference ? nlohmann::json(f.measure()) : nlohmann::json();
    list.push_back(std::move(entry));
  }
  out << list.dump(2) << std::endl;
}

}  // namespace sft::bench
