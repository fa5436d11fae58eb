#include <algorithm>
#include <array>
#include <charconv>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "selection_parser.h"
#include "sft/type_support.h"

namespace sft {

namespace {

using Condition = Selection::Condition;
using Range = Selection::Range;

template <class T>
std::string shortest(T number) {
  std::array<char, 32> text;
  const auto end = std::to_chars(text.data(), text.data() + text.size(), number).ptr;
  return {text.data(), end};
}

std::string text_of(const Selection::Number& number) {
  return std::visit([](auto value) { return shortest(value); }, number);
}

std::string text_of(const Range& range) {
  if (range.is_empty()) return "0:0";
  if (range.end == range.begin + 1) return shortest(range.begin);
  std::string text = range.begin == 0 ? "" : shortest(range.begin);
  text += ':';
  if (range.end != Range::no_end) text += shortest(range.end);
  if (range.step != 1) text += ':' + shortest(range.step);
  return text;
}

/// Prints a duration in the largest unit of which it is a whole multiple.
std::string duration_text(std::uint64_t us) {
  constexpr std::pair<std::uint64_t, std::string_view> units[] = {
      {60'000'000, " min"}, {1'000'000, " s"}, {1'000, " ms"}, {1, " us"}};
  const auto fits = [us](const auto& unit) { return us % unit.first == 0; };
  const auto unit = std::ranges::find_if(units, fits);
  return shortest(us / unit->first) + std::string(unit->second);
}

std::string rate_text(std::chrono::microseconds period) {
  constexpr std::int64_t second = 1'000'000;
  const std::int64_t us = period.count();
  if (us <= second && second % us == 0) return "at most " + shortest(second / us) + " Hz";
  return "at most one per " + duration_text(static_cast<std::uint64_t>(us));
}

std::string ordinal_text(std::uint64_t n) {
  const std::uint64_t last = n % 10;
  const bool is_teen = n % 100 / 10 == 1;
  const char* const ending = is_teen ? "th" : last == 1 ? "st" : last == 2 ? "nd" : last == 3 ? "rd" : "th";
  return shortest(n) + ending;
}

/// Prints conditions, which are stored one after the other as nodes of a tree.
class ConditionPrinter {
 public:
  ConditionPrinter(const TypeSupport& type, const Selection& selection)
      : type_(type),
        scalars_(detail::scalars_of(type, selection.mask())),
        rest_(selection.gate().conditions) {}

  /// Prints the next condition, which is a child of a condition of the kind `outer`.
  std::string print(Condition::Kind outer = Condition::Kind::any_of) {
    const Condition& condition = rest_.front();
    rest_ = rest_.subspan(1);
    switch (condition.kind) {
      case Condition::Kind::all_of:
        return print_children(condition, " and ");
      case Condition::Kind::any_of: {
        const std::string text = print_children(condition, " or ");
        return outer == Condition::Kind::all_of ? "(" + text + ")" : text;
      }
      case Condition::Kind::compare:
        return comparison(condition);
      case Condition::Kind::changed:
        return changed(condition);
      case Condition::Kind::nth:
        return "every " + ordinal_text(std::get<std::uint64_t>(condition.number));
      case Condition::Kind::elapsed:
        return "every " + duration_text(std::get<std::uint64_t>(condition.number));
    }
    return {};
  }

 private:
  std::string print_children(const Condition& condition, std::string_view word) {
    std::string text;
    for (std::uint32_t i = 0; i < condition.children; ++i) {
      if (i > 0) text += word;
      text += print(condition.kind);
    }
    return text;
  }

  std::string comparison(const Condition& condition) const {
    constexpr std::array<std::string_view, 6> signs = {" < ", " <= ", " > ", " >= ", " == ", " != "};
    const std::size_t leaf = condition.leaves.front();
    const auto* value = std::get_if<std::uint64_t>(&condition.number);
    std::string constant = text_of(condition.number);
    const StructType::Member* member = detail::place_of(type_.type(), leaf).member;
    if (value != nullptr && member != nullptr && member->kind == StructType::Member::Kind::boolean &&
        *value < 2)
      constant = *value == 0 ? "false" : "true";
    if (value != nullptr && member != nullptr && member->enumeration != nullptr) {
      for (const EnumType::Enumerator& e : member->enumeration->enumerators) {
        if (e.value == *value) constant = e.name;
      }
    }
    return type_.path(leaf) + std::string(signs[static_cast<std::size_t>(condition.comparison)]) + constant;
  }

  std::string changed(const Condition& condition) const {
    std::string text = "changed";
    if (condition.leaves != scalars_) {
      const char* before = "(";
      for (const std::uint32_t leaf : condition.leaves)
        text += std::exchange(before, ", ") + type_.path(leaf);
      text += ')';
    }
    if (condition.number == Selection::Number(std::uint64_t{0})) return text;
    return text + ' ' + text_of(condition.number) + (condition.is_percent ? "%" : "");
  }

  const TypeSupport& type_;
  const std::vector<std::uint32_t> scalars_;  ///< the fields to which `changed` without names refers
  std::span<const Condition> rest_;
};

std::string part_text(const Selection::Part& part) {
  std::string text;
  const char* before = "{";
  for (const std::string& name : part.channels) text += std::exchange(before, ",") + name;
  if (!part.channels.empty()) text += '}';
  if (part.rows.is_all() && part.columns.is_all()) return text;
  if (part.rows.is_all()) return text + '[' + text_of(part.columns) + ']';
  text += "[rows " + text_of(part.rows);
  if (!part.columns.is_all()) text += ", columns " + text_of(part.columns);
  return text + ']';
}

}  // namespace

Result<Selection> TypeSupport::parse_selection(std::string_view text) const {
  return detail::SelectionParser(*this, text).parse();
}

std::string TypeSupport::format_selection(const Selection& selection) const {
  const std::span<const Selection::Part> parts = selection.parts();
  std::string text;
  if (parts.empty()) {
    text = format_mask(selection.mask());
  } else {
    FieldMask whole = selection.mask();
    for (const Selection::Part& part : parts) whole.erase(part.leaf);
    std::size_t covered = 0;  // leaves below this number are already named
    for (const Node& node : nodes_) {
      if (node.first < covered) continue;
      const Selection::Part* part = node.is_leaf ? selection.part(node.first) : nullptr;
      if (part == nullptr && !whole.all_of(node.first, node.count)) continue;
      text += (text.empty() ? "" : ", ") + node.path + (part == nullptr ? "" : part_text(*part));
      covered = node.first + node.count;
    }
  }
  const Selection::Gate& gate = selection.gate();
  if (gate.is_open()) return text;
  text += text.empty() ? "@" : " @";
  if (!gate.conditions.empty()) text += ' ' + ConditionPrinter(*this, selection).print();
  if (gate.least_period.count() > 0) text += ' ' + rate_text(gate.least_period);
  return text;
}

}  // namespace sft
