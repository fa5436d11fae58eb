#include "tools/perf/criteria.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <iterator>

namespace sft::perf {

namespace {

enum class Kind { time, count, rate };

struct Quantity {
  std::string_view name;
  Kind kind;
};
constexpr Quantity quantities[] = {
    {"min", Kind::time},        {"mean", Kind::time},       {"p50", Kind::time},
    {"p90", Kind::time},        {"p99", Kind::time},        {"p99.9", Kind::time},
    {"p99.99", Kind::time},     {"max", Kind::time},        {"jitter", Kind::time},
    {"first", Kind::time},      {"lost", Kind::count},      {"lost_there", Kind::count},
    {"lost_back", Kind::count}, {"reordered", Kind::count}, {"twice", Kind::count},
    {"late", Kind::count},      {"rate", Kind::rate}};

struct Unit {
  std::string_view name;
  Kind kind;
  double factor;
};
constexpr Unit units[] = {{"ns", Kind::time, 1e-9}, {"us", Kind::time, 1e-6}, {"ms", Kind::time, 1e-3},
                          {"s", Kind::time, 1},     {"%", Kind::count, 0.01}, {"kHz", Kind::rate, 1e3},
                          {"Hz", Kind::rate, 1}};

std::string all_names() {
  std::string names;
  for (const Quantity& quantity : quantities)
    names += (names.empty() ? "" : ", ") + std::string(quantity.name);
  return names;
}

class Reader {
 public:
  explicit Reader(std::string_view text) : text_(text) {}

  Result<std::vector<Criterion>> all() {
    std::vector<Criterion> criteria;
    do {
      Result<Criterion> criterion = one();
      if (!criterion) return tl::unexpected(criterion.error());
      criteria.push_back(*std::move(criterion));
    } while (takes(","));
    skip_blanks();
    if (at_ != text_.size()) return wrong("a comma, or the end");
    return criteria;
  }

 private:
  Result<Criterion> one() {
    skip_blanks();
    const std::size_t begin = at_;
    const auto* const quantity = longest(quantities);
    if (quantity == nullptr) return wrong("one of " + all_names());
    Criterion criterion;
    criterion.name = quantity->name;
    for (const char* comparison : {">=", "<=", ">", "<"}) {
      if (!criterion.comparison.empty() || !takes(comparison)) continue;
      criterion.comparison = comparison;
    }
    if (criterion.comparison.empty()) return wrong("one of >, >=, <, <=");
    skip_blanks();
    const char* const first = text_.data() + at_;
    const auto number = std::from_chars(first, text_.data() + text_.size(), criterion.bound);
    if (number.ec != std::errc() || !std::isfinite(criterion.bound)) return wrong("a number");
    at_ += static_cast<std::size_t>(number.ptr - first);
    skip_blanks();
    const std::size_t before = at_;
    const Unit* const unit = longest(units);
    if (unit == nullptr ? quantity->kind == Kind::time : unit->kind != quantity->kind) {
      at_ = before;
      return wrong(quantity->kind == Kind::time    ? "a unit of time: ns, us, ms or s"
                   : quantity->kind == Kind::count ? "a comma, % or the end"
                                                   : "a comma, Hz, kHz or the end");
    }
    if (unit != nullptr) criterion.bound *= unit->factor;
    criterion.of_all_sent = unit != nullptr && unit->kind == Kind::count;
    criterion.text = text_.substr(begin, at_ - begin);
    return criterion;
  }

  /// Takes the longest name of the table with which the remaining text begins.
  template <class Table>
  auto longest(const Table& table) -> decltype(std::begin(table)) {
    auto found = std::end(table);
    for (auto entry = std::begin(table); entry != std::end(table); ++entry) {
      const bool longer = found == std::end(table) || entry->name.size() > found->name.size();
      if (text_.substr(at_).starts_with(entry->name) && longer) found = entry;
    }
    if (found == std::end(table)) return nullptr;
    at_ += found->name.size();
    return found;
  }

  bool takes(std::string_view word) {
    skip_blanks();
    if (!text_.substr(at_).starts_with(word)) return false;
    at_ += word.size();
    return true;
  }
  void skip_blanks() { at_ = std::min(text_.find_first_not_of(' ', at_), text_.size()); }
  tl::unexpected<Error> wrong(const std::string& expected) const {
    const std::string there =
        at_ < text_.size() ? fmt::format("'{}'", text_.substr(at_)) : std::string("the end");
    return fail(Errc::invalid_argument, fmt::format("'{}': at character {} there is {}, but expected is {}",
                                                    text_, at_ + 1, there, expected));
  }

  std::string_view text_;
  std::size_t at_ = 0;
};

bool holds(double value, const std::string& comparison, double bound) {
  if (comparison == ">") return value > bound;
  if (comparison == ">=") return value >= bound;
  return comparison == "<" ? value < bound : value <= bound;
}

}  // namespace

Result<std::vector<Criterion>> parse_criteria(std::string_view text) { return Reader(text).all(); }

std::vector<std::string> failures(const std::vector<Criterion>& criteria, const Values& values) {
  std::vector<std::string> sentences;
  for (const Criterion& criterion : criteria) {
    const auto found = values.find(criterion.name);
    const auto sent = values.find("sent");
    if (found == values.end() || !found->second) {
      sentences.push_back(fmt::format("{}: {} is not known", criterion.text, criterion.name));
      continue;
    }
    const double of = criterion.of_all_sent && sent != values.end() ? sent->second.value_or(0) : 1;
    if (holds(*found->second, criterion.comparison, criterion.bound * of))
      sentences.push_back(fmt::format("{}: {} is {:g}", criterion.text, criterion.name, *found->second));
  }
  return sentences;
}

}  // namespace sft::perf
