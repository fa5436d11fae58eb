#include "tests/support/gate_reference.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <utility>

namespace sft::test {

namespace {

using namespace detail;

using Condition = Selection::Condition;

/// A natural number of any size. Its digits have 32 bits each, and the last digit, the highest one, is not 0.
class Natural {
 public:
  Natural() = default;
  explicit Natural(std::uint64_t value) {
    digits_ = {static_cast<std::uint32_t>(value), static_cast<std::uint32_t>(value >> 32)};
    trim();
  }

  Natural times_power_of_two(std::size_t exponent) const {
    Natural result;
    result.digits_.assign(exponent / 32, 0);
    std::uint64_t carry = 0;
    for (const std::uint32_t digit : digits_) {
      carry |= std::uint64_t{digit} << exponent % 32;
      result.digits_.push_back(static_cast<std::uint32_t>(carry));
      carry >>= 32;
    }
    result.digits_.push_back(static_cast<std::uint32_t>(carry));
    result.trim();
    return result;
  }
  /// Returns the absolute difference of two numbers.
  Natural distance(const Natural& other) const {
    if (compare(other) < 0) return other.distance(*this);
    Natural result = *this;
    std::int64_t borrowed = 0;
    for (std::size_t i = 0; i < digits_.size(); ++i) {
      const std::int64_t difference = std::int64_t{digits_[i]} - other.digit(i) - borrowed;
      borrowed = difference < 0 ? 1 : 0;
      result.digits_[i] = static_cast<std::uint32_t>(difference);
    }
    result.trim();
    return result;
  }
  Natural plus(const Natural& other) const {
    Natural result;
    std::uint64_t carry = 0;
    for (std::size_t i = 0; i < std::max(digits_.size(), other.digits_.size()) || carry != 0; ++i) {
      carry += std::uint64_t{digit(i)} + other.digit(i);
      result.digits_.push_back(static_cast<std::uint32_t>(carry));
      carry >>= 32;
    }
    return result;
  }
  Natural times(const Natural& other) const {
    Natural result;
    for (std::size_t i = 0; i < digits_.size(); ++i) {
      if (digits_[i] == 0) continue;
      Natural row;
      row.digits_.assign(i, 0);
      std::uint64_t carry = 0;
      for (std::size_t j = 0; j < other.digits_.size() || carry != 0; ++j) {
        carry += std::uint64_t{digits_[i]} * other.digit(j);
        row.digits_.push_back(static_cast<std::uint32_t>(carry));
        carry >>= 32;
      }
      row.trim();
      result = result.plus(row);
    }
    return result;
  }
  /// Returns a negative number, 0 or a positive number if this number is less than, equal to or greater than
  /// `other`.
  int compare(const Natural& other) const {
    if (digits_.size() != other.digits_.size()) return digits_.size() < other.digits_.size() ? -1 : 1;
    for (std::size_t i = digits_.size(); i-- > 0;)
      if (digits_[i] != other.digits_[i]) return digits_[i] < other.digits_[i] ? -1 : 1;
    return 0;
  }

 private:
  std::uint32_t digit(std::size_t i) const { return i < digits_.size() ? digits_[i] : 0; }
  void trim() {
    while (!digits_.empty() && digits_.back() == 0) digits_.pop_back();
  }
  std::vector<std::uint32_t> digits_;
};

/// The exact value of a finite number. The magnitude is in units of the smallest positive double, because
/// every finite double and every integer is a multiple of that unit.
struct Exact {
  static constexpr int unit_exponent = -1074;

  bool is_negative = false;
  Natural magnitude{};

  /// Returns the absolute difference of two numbers.
  Natural distance(const Exact& other) const {
    return is_negative == other.is_negative ? magnitude.distance(other.magnitude)
                                            : magnitude.plus(other.magnitude);
  }
  int compare(const Exact& other) const {
    const Natural zero;
    if (magnitude.compare(zero) == 0 && other.magnitude.compare(zero) == 0) return 0;
    if (is_negative != other.is_negative) return is_negative ? -1 : 1;
    return is_negative ? -magnitude.compare(other.magnitude) : magnitude.compare(other.magnitude);
  }
};

Exact exact(std::uint64_t value) { return {false, Natural(value).times_power_of_two(-Exact::unit_exponent)}; }
Exact exact(std::int64_t value) {
  const auto bits = static_cast<std::uint64_t>(value);
  Exact result = exact(value < 0 ? ~bits + 1 : bits);
  result.is_negative = value < 0;
  return result;
}
Exact exact(double value) {
  constexpr int digits = std::numeric_limits<double>::digits;
  int exponent = 0;
  const double fraction = std::frexp(std::fabs(value), &exponent);  // value = fraction * 2^exponent
  // The bits below the unit are 0.
  const auto shift = exponent - digits - Exact::unit_exponent;
  const auto whole = static_cast<std::uint64_t>(std::ldexp(fraction, digits));
  return {std::signbit(value), shift < 0
                                   ? Natural(whole >> -shift)
                                   : Natural(whole).times_power_of_two(static_cast<std::size_t>(shift))};
}

/// Returns the exact value of a field or of a number in a condition. REQUIRES: the value is no text.
template <class Variant>
Exact exact_of(const Variant& value) {
  if (const auto* natural = std::get_if<std::uint64_t>(&value)) return exact(*natural);
  if (const auto* integer = std::get_if<std::int64_t>(&value)) return exact(*integer);
  return exact(std::get<double>(value));
}

/// Returns the value of a field if it is infinite or a NaN; otherwise 0.
double strange(const FieldValue& value) {
  const auto* real = std::get_if<double>(&value);
  return real != nullptr && !std::isfinite(*real) ? *real : 0;
}

bool compares(const FieldValue& value, Condition::Comparison comparison, const Selection::Number& number) {
  using enum Condition::Comparison;
  const double odd = strange(value);
  if (std::isnan(odd)) return comparison == not_equal;
  const int order = odd != 0 ? (odd < 0 ? -1 : 1) : exact_of(value).compare(exact_of(number));
  switch (comparison) {
    case less:
      return order < 0;
    case less_or_equal:
      return order <= 0;
    case greater:
      return order > 0;
    case greater_or_equal:
      return order >= 0;
    case equal:
      return order == 0;
    case not_equal:
      return order != 0;
  }
  return false;
}

struct Change {
  bool is_one;
  bool is_close = false;
};

Change change(const FieldValue& now, const FieldValue& before, const Condition& condition) {
  if (const auto* text = std::get_if<std::string>(&now)) return {*text != std::get<std::string>(before)};
  const double odd_now = strange(now), odd_before = strange(before);
  if (std::isnan(odd_now) || std::isnan(odd_before)) return {std::isnan(odd_now) != std::isnan(odd_before)};
  if (odd_now != 0 || odd_before != 0) return {odd_now != odd_before};
  const Exact former = exact_of(before);
  // Compares distance > deadband, or distance > deadband / 100 * |former|. All these numbers are in units
  // of the smallest positive double (Exact).
  const Natural whole = condition.is_percent ? former.magnitude : exact(std::uint64_t{1}).magnitude;
  const Natural parts = exact(std::uint64_t{condition.is_percent ? 100U : 1U}).magnitude;
  const Natural distance = exact_of(now).distance(former).times(parts);
  const Natural most = exact_of(condition.number).magnitude.times(whole);
  const Natural beyond = distance.distance(most);
  constexpr std::size_t binary_digits = 60;
  return {distance.compare(most) > 0,
          distance.compare(most) != 0 && beyond.times_power_of_two(binary_digits).compare(most) < 0};
}

template <class T>
T value_at(const std::byte* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return value;
}

FieldValue value_of(Kind kind, const std::byte* at) {
  switch (kind) {
    case Kind::boolean:
    case Kind::octet:
    case Kind::character:
    case Kind::uint8:
      return std::uint64_t{value_at<std::uint8_t>(at)};
    case Kind::uint16:
      return std::uint64_t{value_at<std::uint16_t>(at)};
    case Kind::uint32:
      return std::uint64_t{value_at<std::uint32_t>(at)};
    case Kind::uint64:
      return value_at<std::uint64_t>(at);
    case Kind::int8:
      return std::int64_t{value_at<std::int8_t>(at)};
    case Kind::int16:
      return std::int64_t{value_at<std::int16_t>(at)};
    case Kind::int32:
      return std::int64_t{value_at<std::int32_t>(at)};
    case Kind::int64:
      return value_at<std::int64_t>(at);
    case Kind::float32:
      return double{value_at<float>(at)};
    case Kind::float64:
      return value_at<double>(at);
    default:
      return *reinterpret_cast<const std::string*>(at);
  }
}

void add_fields(const StructType& type, std::uint32_t leaf, std::size_t offset,
                std::vector<SingleField>& fields) {
  for (const StructType::Member& m : type.members) {
    if (m.shape == Shape::single && m.kind == Kind::structure) {
      add_fields(*m.type, leaf, offset + m.offset, fields);
    } else if (m.shape == Shape::single) {
      fields.push_back({leaf, &m, offset + m.offset});
    }
    leaf += static_cast<std::uint32_t>(leaf_count(m));
  }
}

}  // namespace

std::vector<SingleField> single_fields(const StructType& type) {
  std::vector<SingleField> fields;
  add_fields(type, 0, 0, fields);
  return fields;
}

FieldValues values_of(std::span<const SingleField> fields, const void* message) {
  FieldValues values;
  for (const SingleField& field : fields)
    values[field.leaf] = value_of(field.member->kind, static_cast<const std::byte*>(message) + field.offset);
  return values;
}

GateReference::GateReference(const std::vector<Condition>& conditions) {
  std::size_t next = 0;
  if (!conditions.empty()) root_ = tree(conditions, next);
}

GateReference::Node GateReference::tree(const std::vector<Condition>& conditions, std::size_t& next) {
  Node node{conditions.at(next++)};
  for (std::uint32_t i = 0; i < node.condition.children; ++i) node.children.push_back(tree(conditions, next));
  return node;
}

bool GateReference::holds(const FieldValues& sample, std::int64_t stamp_ns) {
  ++asked_about_;
  was_close_ = false;
  period_from_ns_ = std::min(period_from_ns_, stamp_ns);  // the stamp is earlier if the clock was set back
  return !root_ || holds(*root_, sample, stamp_ns);
}

void GateReference::passed(const FieldValues& sample, std::int64_t stamp_ns) {
  begins_ = false;
  former_ = sample;
  period_from_ns_ = stamp_ns;
}

bool GateReference::holds(const Node& node, const FieldValues& sample, std::int64_t stamp_ns) {
  const auto child_holds = [&](const Node& child) { return holds(child, sample, stamp_ns); };
  const Condition& condition = node.condition;
  switch (condition.kind) {
    case Condition::Kind::all_of:
      return std::ranges::all_of(node.children, child_holds);
    case Condition::Kind::any_of:
      return std::ranges::any_of(node.children, child_holds);
    case Condition::Kind::compare:
      return compares(sample.at(condition.leaves.at(0)), condition.comparison, condition.number);
    case Condition::Kind::changed:
      return has_changed(condition, sample);
    case Condition::Kind::nth:
      // The condition holds for the first sample, and for each n-th sample after it.
      return begins_ || (asked_about_ - 1) % std::get<std::uint64_t>(condition.number) == 0;
    case Condition::Kind::elapsed: {
      // The stamp is never earlier than the beginning of the period, and the difference of two stamps fits
      // into 64 bits.
      const std::uint64_t since_ns =
          static_cast<std::uint64_t>(stamp_ns) - static_cast<std::uint64_t>(period_from_ns_);
      return begins_ || since_ns / 1000 >= std::get<std::uint64_t>(condition.number);
    }
  }
  return false;
}

bool GateReference::has_changed(const Condition& condition, const FieldValues& sample) {
  return begins_ || std::ranges::any_of(condition.leaves, [&](std::uint32_t leaf) {
           const Change change_of_leaf = change(sample.at(leaf), former_.at(leaf), condition);
           was_close_ = was_close_ || change_of_leaf.is_close;
           return change_of_leaf.is_one;
         });
}

}  // namespace sft::test
