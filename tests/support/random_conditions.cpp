#include "tests/support/random_conditions.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

namespace sft::test {

namespace {

using namespace detail;

using Condition = Selection::Condition;
using Number = Selection::Number;

// The limits of the integers that doubles represent exactly, and integers just beyond these limits. Decimals
// that no float equals. The smallest and the largest numbers.
const std::array<Number, 30> constants{std::uint64_t{0},
                                       std::uint64_t{1},
                                       std::int64_t{-1},
                                       std::uint64_t{2},
                                       std::uint64_t{127},
                                       std::int64_t{-128},
                                       std::uint64_t{255},
                                       std::uint64_t{INT32_MAX},
                                       std::int64_t{INT32_MIN},
                                       std::uint64_t{UINT32_MAX},
                                       std::uint64_t{INT64_MAX},
                                       std::int64_t{INT64_MIN},
                                       std::int64_t{INT64_MIN + 1},
                                       std::uint64_t{UINT64_MAX},
                                       std::uint64_t{1} << 53,
                                       (std::uint64_t{1} << 53) + 1,
                                       std::uint64_t{16'777'217},  // equals no float, but a double
                                       0x1p64,
                                       0x1p63,
                                       -0x1p64,
                                       0.1,
                                       -0.3,
                                       0.5,
                                       1.5,
                                       4.04,
                                       1e300,
                                       -1e300,
                                       5e-324,
                                       3.4028234663852886e38,
                                       1e-45};
const std::array<Number, 20> deadbands{std::uint64_t{0},
                                       std::uint64_t{0},
                                       std::uint64_t{0},
                                       std::uint64_t{1},
                                       std::uint64_t{2},
                                       std::uint64_t{10},
                                       std::uint64_t{100},
                                       std::uint64_t{200},
                                       std::uint64_t{255},
                                       std::uint64_t{1} << 53,
                                       std::uint64_t{INT64_MAX},
                                       std::uint64_t{UINT64_MAX},
                                       0.1,
                                       0.5,
                                       0.01,
                                       1.5,
                                       33.3,
                                       1e-300,
                                       5e-324,
                                       1e300};
constexpr std::array<std::uint64_t, 8> periods{1,         7,          1000,        100'000,
                                               1'000'000, 10'000'000, 120'000'000, 86'400'000'000};

double as_real(const Number& number) {
  return std::visit([](auto value) { return static_cast<double>(value); }, number);
}

template <class T>
std::string digits(T value) {
  std::array<char, 64> memory;
  return {memory.data(), std::to_chars(memory.data(), memory.data() + memory.size(), value).ptr};
}
std::string text_of(const Number& number) {
  return std::visit([](auto value) { return digits(value); }, number);
}

std::string ordinal(std::uint64_t n) {
  const bool is_teen = n / 10 % 10 == 1;
  const char* end = is_teen || n % 10 > 3 || n % 10 == 0 ? "th"
                    : n % 10 == 1                        ? "st"
                    : n % 10 == 2                        ? "nd"
                                                         : "rd";
  return digits(n) + end;
}
std::string duration(std::uint64_t us) {
  if (us % 60'000'000 == 0) return digits(us / 60'000'000) + " min";
  if (us % 1'000'000 == 0) return digits(us / 1'000'000) + " s";
  return us % 1000 == 0 ? digits(us / 1000) + "ms" : digits(us) + " us";
}

}  // namespace

std::vector<Condition> RandomConditions::conditions() {
  const std::uint64_t most = one_in(3) ? Selection::conditions_max : 6;
  std::vector<Condition> result;
  add(result, 1 + below(most), 1);
  return result;
}

/// Adds a random tree of at most `nodes` nodes to `to`.
void RandomConditions::add(std::vector<Condition>& to, std::size_t nodes, std::size_t depth) {
  if (nodes < 3 || depth == Selection::depth_max) {
    to.push_back(condition());
    return;
  }
  --nodes;
  const std::size_t children = 2 + below(std::min<std::size_t>(nodes, 4) - 1);
  to.push_back({.kind = one_in(2) ? Condition::Kind::all_of : Condition::Kind::any_of,
                .children = static_cast<std::uint32_t>(children)});
  for (std::size_t left = children; left > 0; --left) {
    const std::size_t share = left == 1 ? nodes : 1 + below(nodes - left + 1);
    const std::size_t before = to.size();
    add(to, share, depth + 1);
    nodes -= to.size() - before;
  }
}

Condition RandomConditions::condition() {
  using enum Condition::Kind;
  const auto leaf = [&] { return fields_[below(fields_.size())].leaf; };
  switch (below(8)) {
    case 0:
      return {.kind = nth, .number = 1 + (one_in(20) ? UINT64_MAX - 1 : below(5))};
    case 1:
      return {.kind = elapsed, .number = period_us()};
    case 2:
    case 3:
    case 4: {
      Condition changes{.kind = changed, .is_percent = one_in(2)};
      for (std::uint64_t left = 1 + below(4); left > 0; --left) changes.leaves.push_back(leaf());
      std::ranges::sort(changes.leaves);
      changes.leaves.erase(std::unique(changes.leaves.begin(), changes.leaves.end()), changes.leaves.end());
      changes.number = deadband();
      changes.is_percent = changes.is_percent && as_real(changes.number) != 0;
      return changes;
    }
    default:
      break;
  }
  const SingleField& field = fields_[below(fields_.size())];
  if (field.member->kind == Kind::string) return {.kind = changed, .leaves = {field.leaf}};
  Condition compares{.kind = compare, .leaves = {field.leaf}};
  compares.comparison = static_cast<Condition::Comparison>(below(6));
  compares.number = constant();
  if (field.member->enumeration != nullptr && one_in(2)) {
    const auto names = field.member->enumeration->enumerators;
    compares.number = names[below(names.size())].value;
  }
  return compares;
}

Number RandomConditions::constant() {
  Number result = constants[below(constants.size())];
  if (one_in(4)) result = std::nextafter(as_real(result), one_in(2) ? -INFINITY : INFINITY);
  if (one_in(4)) result = static_cast<double>(static_cast<float>(below(1000))) / 8;
  numbers_.push_back(result);
  return result;
}

Number RandomConditions::deadband() {
  Number result = deadbands[below(deadbands.size())];
  if (one_in(8)) result = std::nextafter(as_real(result), INFINITY);
  numbers_.push_back(result);
  return result;
}

std::uint64_t RandomConditions::period_us() {
  periods_us_.push_back(periods[below(periods.size())]);
  return periods_us_.back();
}

std::string RandomConditions::text(const TypeSupport& type, const std::vector<Condition>& conditions) {
  std::size_t next = 0;
  return text(type, conditions, next, nullptr);
}

std::string RandomConditions::text(const TypeSupport& type, const std::vector<Condition>& conditions,
                                   std::size_t& next, const Condition* parent) {
  using enum Condition::Kind;
  const Condition& node = conditions[next++];
  if (node.kind == compare) return text_of_comparison(type, node);
  if (node.kind == changed) return text_of_change(type, node);
  if (node.kind == nth) return "every" + blank() + ordinal(std::get<std::uint64_t>(node.number));
  if (node.kind == elapsed) return "every" + blank() + duration(std::get<std::uint64_t>(node.number));
  std::string result;
  for (std::uint32_t i = 0; i < node.children; ++i) {
    if (i > 0) result += blank() + (node.kind == all_of ? "and" : "or") + blank();
    result += text(type, conditions, next, &node);
  }
  // Parentheses are necessary only around an "or" inside an "and".
  const bool is_needed = parent != nullptr && parent->kind == all_of && node.kind == any_of;
  if (is_needed || (parent != nullptr && one_in(2))) result = "(" + result + ")";
  return result;
}

std::string RandomConditions::text_of_comparison(const TypeSupport& type, const Condition& condition) {
  constexpr std::array<const char*, 6> signs{"<", "<=", ">", ">=", "==", "!="};
  const std::uint32_t leaf = condition.leaves[0];
  const StructType::Member& member = *std::ranges::find(fields_, leaf, &SingleField::leaf)->member;
  std::string constant = text_of(condition.number);
  if (member.kind == Kind::boolean && one_in(2)) {
    if (condition.number == Number(std::uint64_t{0})) constant = "false";
    if (condition.number == Number(std::uint64_t{1})) constant = "true";
  }
  if (member.enumeration != nullptr && one_in(2)) {
    for (const EnumType::Enumerator& name : member.enumeration->enumerators)
      if (condition.number == Number(name.value)) constant = name.name;
  }
  const std::string space = one_in(4) ? "" : " ";
  return type.path(leaf) + space + signs[static_cast<std::size_t>(condition.comparison)] + space + constant;
}

std::string RandomConditions::text_of_change(const TypeSupport& type, const Condition& condition) {
  std::string result = "changed(";
  for (const std::uint32_t leaf : condition.leaves)
    result += (result.back() == '(' ? "" : ", ") + type.path(leaf);
  result += ")";
  if (as_real(condition.number) == 0 && !one_in(4)) return result;
  return result + blank() + text_of(condition.number) + (condition.is_percent ? "%" : "");
}

void RandomConditions::change(void* message) {
  for (const SingleField& field : fields_)
    if (one_in(2)) change_field(field, static_cast<std::byte*>(message) + field.offset);
}

void RandomConditions::change_field(const SingleField& field, std::byte* at) {
  const EnumType* enumeration = field.member->enumeration;
  switch (field.member->kind) {
    case Kind::boolean:
      *at = std::byte(below(2));
      return;
    case Kind::octet:
    case Kind::uint8:
      return change_integer<std::uint8_t>(at, enumeration);
    case Kind::character:
      return change_integer<std::uint8_t>(at);
    case Kind::int8:
      return change_integer<std::int8_t>(at, enumeration);
    case Kind::int16:
      return change_integer<std::int16_t>(at, enumeration);
    case Kind::uint16:
      return change_integer<std::uint16_t>(at, enumeration);
    case Kind::int32:
      return change_integer<std::int32_t>(at, enumeration);
    case Kind::uint32:
      return change_integer<std::uint32_t>(at, enumeration);
    case Kind::int64:
      return change_integer<std::int64_t>(at, enumeration);
    case Kind::uint64:
      return change_integer<std::uint64_t>(at, enumeration);
    case Kind::float32:
      return change_real<float>(at);
    case Kind::float64:
      return change_real<double>(at);
    case Kind::string:
      return change_text(*reinterpret_cast<std::string*>(at),
                         field.member->string_bound == 0 ? SIZE_MAX : field.member->string_bound);
    case Kind::structure:
      return;
  }
}

/// Returns a random value for a field, often close to a number of the conditions or to the former value. If
/// the conditions have no numbers, any constant takes the place of their numbers.
double RandomConditions::real(double former) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  constexpr std::array<double, 7> strange{NAN, infinity, -infinity, -0.0, 0.0, 5e-324, -1.7e308};
  const double number =
      as_real(numbers_.empty() ? constants[below(constants.size())] : numbers_[below(numbers_.size())]);
  const double sign = one_in(2) ? 1 : -1;
  switch (below(7)) {
    case 0:
      return strange[below(strange.size())];
    case 1:
      return sign * number;
    case 2:
      return std::nextafter(number, sign * infinity);
    case 3:
      return former + sign * number;
    case 4:
      return former * (1 + sign * number / 100);
    case 5:
      return std::nextafter(former, sign * infinity);
    default:
      return sign * static_cast<double>(below(1000)) / 8;
  }
}

template <class Real>
void RandomConditions::change_real(std::byte* at) {
  Real value;
  std::memcpy(&value, at, sizeof value);
  value = static_cast<Real>(real(value));
  // A step to the next float is larger than a step to the next double.
  if (one_in(4)) value = std::nextafter(value, one_in(2) ? Real(INFINITY) : -Real(INFINITY));
  std::memcpy(at, &value, sizeof value);
}

template <class Integer>
Integer RandomConditions::integer(Integer former, const EnumType* enumeration) {
  using Limits = std::numeric_limits<Integer>;
  // Added below as an unsigned number, because the sum may wrap around.
  const auto near = static_cast<Integer>(below(5));
  switch (below(6)) {
    case 0:
      return one_in(2) ? Limits::min() : Limits::max();
    case 1:
      return static_cast<Integer>(random_());
    case 2:
      if (enumeration == nullptr) return near;
      return static_cast<Integer>(enumeration->enumerators[below(enumeration->enumerators.size())].value);
    case 3:
      return static_cast<Integer>(static_cast<std::uint64_t>(former) + static_cast<std::uint64_t>(near) - 2);
    default:
      break;
  }
  if (numbers_.empty()) return near;
  const Number& number = numbers_[below(numbers_.size())];
  const double value = as_real(number) + (one_in(4) ? static_cast<double>(former) : 0);
  if (value <= static_cast<double>(Limits::min())) return Limits::min();
  if (value >= static_cast<double>(Limits::max())) return Limits::max();
  return static_cast<Integer>(static_cast<std::uint64_t>(static_cast<Integer>(value)) + below(3) - 1);
}

template <class Integer>
void RandomConditions::change_integer(std::byte* at, const EnumType* enumeration) {
  Integer value;
  std::memcpy(&value, at, sizeof value);
  value = integer(value, enumeration);
  std::memcpy(at, &value, sizeof value);
}

void RandomConditions::change_text(std::string& text, std::size_t most) {
  switch (below(4)) {
    case 0:
      text.clear();
      break;
    case 1:
      text += static_cast<char>('a' + below(3));
      break;
    case 2:
      if (!text.empty()) text[below(text.size())] = static_cast<char>('a' + below(3));
      break;
    default:
      text.assign(below(60), 'x');  // mostly too long to be stored without an allocation
      break;
  }
  if (text.size() > most) text.resize(most);
}

std::int64_t RandomConditions::stamp_behind(std::int64_t stamp_ns) {
  const std::uint64_t period = periods_us_.empty() ? 1000 : periods_us_[below(periods_us_.size())];
  const auto period_ns = static_cast<std::int64_t>(period * 1000);
  const auto some = [&] {
    return static_cast<std::int64_t>(below(static_cast<std::uint64_t>(period_ns) + 1));
  };
  switch (below(10)) {
    case 0:
      return stamp_ns;
    case 1:
      return stamp_ns - some();
    case 2:
      return stamp_ns - 3 * period_ns;
    case 3:
      return stamp_ns + period_ns - 1;
    case 4:
    case 5:
      return stamp_ns + period_ns;
    case 6:
      return stamp_ns + 3 * some();
    default:
      return stamp_ns + some() / 3;
  }
}

}  // namespace sft::test
