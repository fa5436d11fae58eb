#include "sft/detail/conditions.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <compare>
#include <cstring>
#include <functional>
#include <string>
#include <string_view>
#include <utility>
#include <variant>

#include "sft/detail/layout.h"

namespace sft::detail {

namespace {

using Condition = Selection::Condition;
using Number = Selection::Number;

bool is_single_value(const Layout::Field& field) {
  return field && field.member->kind != Kind::structure && field.member->shape == Shape::single;
}

/// Returns the offset of the field in the program's message. The field must not be in an array or a
/// sequence.
std::size_t offset_of(const StructType& type, std::size_t leaf) {
  std::size_t first = 0;
  for (const Member& member : type.members) {
    const std::size_t leaves = leaf_count(member);
    if (leaf < first + leaves)
      return member.offset + (member.kind == Kind::structure ? offset_of(*member.type, leaf - first) : 0);
    first += leaves;
  }
  return 0;
}

/// Returns the number with these bits. The kind determines how many bits are used.
Number number_of(Kind kind, std::uint64_t bits) {
  switch (kind) {
    case Kind::int8:
      return std::int64_t{static_cast<std::int8_t>(bits)};
    case Kind::int16:
      return std::int64_t{static_cast<std::int16_t>(bits)};
    case Kind::int32:
      return std::int64_t{static_cast<std::int32_t>(bits)};
    case Kind::int64:
      return static_cast<std::int64_t>(bits);
    case Kind::float32:
      return double{std::bit_cast<float>(static_cast<std::uint32_t>(bits))};
    case Kind::float64:
      return std::bit_cast<double>(bits);
    default:
      return bits;
  }
}

template <class Bits>
std::uint64_t bits_of(const std::byte* at) {
  Bits bits;
  std::memcpy(&bits, at, sizeof bits);
  return bits;
}

bool is_real(Kind kind) { return kind == Kind::float32 || kind == Kind::float64; }

/// Converts the number to a double if the result is exact, because a comparison of two doubles is the
/// fastest.
Number as_real(const Number& number) {
  constexpr std::uint64_t all_are_exact = std::uint64_t{1} << 53;
  const auto* natural = std::get_if<std::uint64_t>(&number);
  if (natural != nullptr && *natural <= all_are_exact) return static_cast<double>(*natural);
  return number;
}

template <class Integer>
std::partial_ordering compare(Integer whole, double real) {
  if (std::isnan(real)) return std::partial_ordering::unordered;
  if (real >= 0x1p64) return std::partial_ordering::less;
  if (real < -0x1p63) return std::partial_ordering::greater;
  const double below = std::trunc(real);
  const auto is_less = [whole](auto other) { return std::cmp_less(whole, other); };
  const auto is_equal = [whole](auto other) { return std::cmp_equal(whole, other); };
  const auto decide = [&](auto other) -> std::partial_ordering {
    if (!is_equal(other))
      return is_less(other) ? std::partial_ordering::less : std::partial_ordering::greater;
    return below <=> real;
  };
  return below < 0 ? decide(static_cast<std::int64_t>(below)) : decide(static_cast<std::uint64_t>(below));
}

/// Compares the exact values, whatever the types of the two numbers are.
std::partial_ordering compare(const Number& a, const Number& b) {
  return std::visit(
      [](auto x, auto y) -> std::partial_ordering {
        constexpr bool x_is_real = std::is_same_v<decltype(x), double>;
        constexpr bool y_is_real = std::is_same_v<decltype(y), double>;
        if constexpr (x_is_real && y_is_real) {
          return x <=> y;
        } else if constexpr (y_is_real) {
          return compare(x, y);
        } else if constexpr (x_is_real) {
          return 0 <=> compare(y, x);
        } else {
          if (std::cmp_equal(x, y)) return std::partial_ordering::equivalent;
          return std::cmp_less(x, y) ? std::partial_ordering::less : std::partial_ordering::greater;
        }
      },
      a, b);
}

bool is_nan(const Number& number) {
  const auto* real = std::get_if<double>(&number);
  return real != nullptr && std::isnan(*real);
}

long double real_of(const Number& number) {
  return std::visit([](auto value) { return static_cast<long double>(value); }, number);
}

/// Returns true if the number differs from its former value by more than the deadband. A `long double` holds
/// each integer of 64 bits exactly.
bool is_beyond(const Number& now, const Number& before, const Condition& condition) {
  if (is_nan(now) || is_nan(before)) return is_nan(now) != is_nan(before);
  if (compare(now, before) == 0) return false;
  const long double former = real_of(before);
  const long double distance = std::fabs(real_of(now) - former);
  if (!condition.is_percent) return distance > real_of(condition.number);
  if (std::isinf(former)) return true;
  return distance * 100 > real_of(condition.number) * std::fabs(former);
}

}  // namespace

Result<void> Conditions::check(const StructType& type, std::span<const Condition> conditions) {
  for (const Condition& condition : conditions) {
    for (const std::uint32_t leaf : condition.leaves) {
      if (leaf >= type.leaves || !is_single_value(field_at(type, leaf)))
        return fail(Errc::invalid_argument, "a condition is not on a single value");
      const bool is_text = field_at(type, leaf).member->kind == Kind::string;
      if (is_text && condition.kind == Condition::Kind::compare)
        return fail(Errc::invalid_argument, "texts are not compared; use 'changed'");
    }
  }
  return {};
}

Conditions::Conditions(const StructType& type, std::vector<Condition> conditions) {
  for (Condition& condition : conditions) {
    Node& node = conditions_.emplace_back();
    for (const std::uint32_t leaf : condition.leaves) node.fields.push_back(enter(type, leaf));
    const bool is_compared = condition.kind == Condition::Kind::compare;
    if (is_compared && is_real(fields_[node.fields[0]].kind)) condition.number = as_real(condition.number);
    node.condition = std::move(condition);
  }
  if (!conditions_.empty()) enter_children(0);
}

std::size_t Conditions::enter(const StructType& type, std::uint32_t leaf) {
  const auto known = std::ranges::find(fields_, leaf, &Field::leaf);
  if (known != fields_.end()) return static_cast<std::size_t>(known - fields_.begin());
  const Layout::Field field = field_at(type, leaf);
  fields_.push_back(
      {.kind = field.member->kind, .leaf = leaf, .slot = field.slot, .offset = offset_of(type, leaf)});
  return fields_.size() - 1;
}

/// Determines the index of the node that follows the last child of this node. Stores this index and returns
/// it.
std::size_t Conditions::enter_children(std::size_t node) {
  std::size_t end = node + 1;
  for (std::uint32_t i = 0; i < conditions_[node].condition.children; ++i) end = enter_children(end);
  return conditions_[node].end = end;
}

bool Conditions::hold(const FieldSource& sample, std::int64_t stamp_ns) {
  ++samples_;
  // If the clock was set back, the time counts from the new stamp.
  if (stamp_ns < passed_at_ns_) passed_at_ns_ = stamp_ns;
  return conditions_.empty() || holds(0, sample, stamp_ns);
}

void Conditions::passed(const FieldSource& sample, std::int64_t stamp_ns) {
  begins_ = false;
  passed_at_ns_ = stamp_ns;
  for (const Node& node : conditions_) {
    if (node.condition.kind != Condition::Kind::changed) continue;
    for (const std::size_t i : node.fields) {
      Field& field = fields_[i];
      if (field.kind == Kind::string) {
        const std::string_view text = text_at(field, sample);
        field.length = text.size();
        field.bits = std::hash<std::string_view>()(text);
      } else {
        field.bits = bits_at(field, sample);
      }
    }
  }
}

bool Conditions::holds(std::size_t at, const FieldSource& sample, std::int64_t stamp_ns) const {
  const Node& node = conditions_[at];
  switch (node.condition.kind) {
    case Condition::Kind::all_of:
    case Condition::Kind::any_of:
      return holds_of_children(node, at + 1, sample, stamp_ns);
    case Condition::Kind::compare:
      return compares(node, sample);
    case Condition::Kind::changed:
      return begins_ || std::ranges::any_of(node.fields, [&](std::uint32_t i) {
               return has_changed(fields_[i], node.condition, sample);
             });
    case Condition::Kind::nth:
      return begins_ || (samples_ - 1) % std::get<std::uint64_t>(node.condition.number) == 0;
    case Condition::Kind::elapsed: {
      const std::uint64_t period_us = std::get<std::uint64_t>(node.condition.number);
      // The difference is not negative, because hold() ensures that.
      return begins_ || static_cast<std::uint64_t>(stamp_ns) - static_cast<std::uint64_t>(passed_at_ns_) >=
                            period_us * 1000;
    }
  }
  return false;
}

bool Conditions::holds_of_children(const Node& node, std::size_t first, const FieldSource& sample,
                                   std::int64_t stamp_ns) const {
  const bool is_any = node.condition.kind == Condition::Kind::any_of;
  for (std::size_t child = first; child < node.end; child = conditions_[child].end) {
    if (holds(child, sample, stamp_ns) == is_any) return is_any;
  }
  return !is_any;
}

bool Conditions::compares(const Node& node, const FieldSource& sample) const {
  using Comparison = Condition::Comparison;
  const Field& field = fields_[node.fields[0]];
  const std::partial_ordering order =
      compare(number_of(field.kind, bits_at(field, sample)), node.condition.number);
  switch (node.condition.comparison) {
    case Comparison::less:
      return order < 0;
    case Comparison::less_or_equal:
      return order <= 0;
    case Comparison::greater:
      return order > 0;
    case Comparison::greater_or_equal:
      return order >= 0;
    case Comparison::equal:
      return order == 0;
    case Comparison::not_equal:
      return order != 0;
  }
  return false;
}

bool Conditions::has_changed(const Field& field, const Condition& condition, const FieldSource& sample) {
  if (field.kind == Kind::string) {
    const std::string_view text = text_at(field, sample);
    return text.size() != field.length || std::hash<std::string_view>()(text) != field.bits;
  }
  const std::uint64_t bits = bits_at(field, sample);
  if (bits == field.bits) return false;
  return is_beyond(number_of(field.kind, bits), number_of(field.kind, field.bits), condition);
}

const std::byte* Conditions::find_in_message(const Field& field, const FieldSource& sample) {
  return sample.message_ + (sample.other_ == nullptr ? field.offset : offset_of(*sample.other_, field.leaf));
}

/// Returns the address of the field's value; null if the bytes of an encoded sample are malformed.
const std::byte* Conditions::find(const Field& field, const FieldSource& sample) {
  if (sample.message_ != nullptr) return find_in_message(field, sample);
  if (sample.sample_ == nullptr) return nullptr;
  const SampleState& s = *sample.sample_;
  const std::uint32_t offset = __atomic_load_n(s.index + field.slot, __ATOMIC_RELAXED);
  const std::uint32_t at = offset == no_offset ? no_offset : checked_block(s, offset, 1, size_of(field.kind));
  return at == no_offset ? nullptr : s.body + at;
}

/// Returns the bits of the number, extended with zeros to 64 bits. Returns 0 if the sample does not have
/// the number.
std::uint64_t Conditions::bits_at(const Field& field, const FieldSource& sample) {
  const std::byte* const at = find(field, sample);
  if (at == nullptr) return 0;
  switch (size_of(field.kind)) {  // a copy of a variable number of bytes would be a function call
    case 1:
      return bits_of<std::uint8_t>(at);
    case 2:
      return bits_of<std::uint16_t>(at);
    case 4:
      return bits_of<std::uint32_t>(at);
    default:
      return bits_of<std::uint64_t>(at);
  }
}

std::string_view Conditions::text_at(const Field& field, const FieldSource& sample) {
  if (sample.message_ != nullptr)
    return *reinterpret_cast<const std::string*>(find_in_message(field, sample));
  if (sample.sample_ == nullptr) return {};
  const SampleState& s = *sample.sample_;
  const std::uint32_t offset = __atomic_load_n(s.index + field.slot, __ATOMIC_RELAXED);
  const Extent text = offset == no_offset ? Extent{} : checked_string(s, offset);
  return text ? std::string_view(reinterpret_cast<const char*>(s.body + text.first), text.count)
              : std::string_view();
}

}  // namespace sft::detail
