#include "spelling.h"

#include <fmt/format.h>

#include <array>
#include <cstdint>
#include <limits>
#include <span>

#include "naming.h"

namespace sft::idl {
namespace {

struct Spelling {
  std::string_view kind;
  std::string_view type;
};

/// The spellings of kinds, indexed by sft_kind.
constexpr std::array<Spelling, SFT_STRUCTURE + 1> spellings{{
    {"boolean", "bool"},
    {"octet", "std::uint8_t"},
    {"character", "char"},
    {"int8", "std::int8_t"},
    {"uint8", "std::uint8_t"},
    {"int16", "std::int16_t"},
    {"uint16", "std::uint16_t"},
    {"int32", "std::int32_t"},
    {"uint32", "std::uint32_t"},
    {"int64", "std::int64_t"},
    {"uint64", "std::uint64_t"},
    {"float32", "float"},
    {"float64", "double"},
    {"string", "std::string"},
    {"structure", ""},
}};

std::string escaped(char c, char quote) {
  if (c == quote || c == '\\') return {'\\', c};
  const auto code = static_cast<unsigned char>(c);
  // Bytes of UTF-8 are allowed only in strings.
  const bool is_foreign_to_char = quote == '\'' && code >= 0x80;
  return code < 0x20 || code == 0x7F || is_foreign_to_char ? fmt::format("\\{:03o}", code)
                                                           : std::string(1, c);
}

std::string quoted(std::string_view text, char quote) {
  std::string result(1, quote);
  for (const char c : text) result += escaped(c, quote);
  return result + quote;
}

std::string integer_text(std::int64_t value) {
  // The lowest integer has no literal: in -9223372036854775808, the minus sign applies to a number that is
  // too large.
  if (value == std::numeric_limits<std::int64_t>::min()) return fmt::format("({} - 1)", value + 1);
  return fmt::to_string(value);
}

/// Returns a literal of floating-point type that has exactly this value.
template <class Real>
std::string real_text(Real value) {
  const std::string digits = fmt::to_string(value);
  return digits.find_first_of(".e") == std::string::npos ? digits + ".0" : digits;
}

}  // namespace

bool is_single(const sft_type& type) { return !type.is_sequence && type.dimension_count == 0; }

bool is_structure(const sft_type& type) { return type.kind == SFT_STRUCTURE; }

bool is_enumeration(const sft_type& type) {
  return type.name != nullptr && !is_structure(type) && !is_bitmask(type);
}

bool is_bitmask(const sft_type& type) {
  const bool is_unsigned =
      type.kind == SFT_UINT8 || type.kind == SFT_UINT16 || type.kind == SFT_UINT32 || type.kind == SFT_UINT64;
  return type.name != nullptr && is_unsigned;
}

std::string kind_name(sft_kind kind) { return fmt::format("sft::detail::Kind::{}", spellings[kind].kind); }

std::string element_type(const sft_type& type) {
  if (type.name != nullptr) return qualified_type(type.name);
  const sft_kind kind = type.kind == SFT_BOOLEAN && !is_single(type) ? SFT_UINT8 : type.kind;
  return std::string(spellings[kind].type);
}

std::string owned_type(const sft_type& type) {
  std::string result = element_type(type);
  if (type.is_sequence) return fmt::format("std::vector<{}>", result);
  for (std::size_t i = type.dimension_count; i > 0; --i) {
    result = fmt::format("std::array<{}, {}>", result, type.dimensions[i - 1]);
  }
  return result;
}

std::string constant_type(const sft_type& type) {
  return type.kind == SFT_STRING ? "std::string_view" : element_type(type);
}

std::string value_text(const sft_type& type, const sft_value& value) {
  if (is_enumeration(type)) return fmt::format("{}::{}", qualified_type(type.name), identifier(value.text));
  if (is_bitmask(type))
    return fmt::format("{}{{{}}}", qualified_type(type.name), natural_text(value.natural));
  switch (type.kind) {
    case SFT_BOOLEAN:
      return value.boolean ? "true" : "false";
    case SFT_CHARACTER:
      return quoted({&value.character, 1}, '\'');
    case SFT_INT8:
    case SFT_INT16:
    case SFT_INT32:
    case SFT_INT64:
      return integer_text(value.integer);
    case SFT_FLOAT32:
      return real_text(static_cast<float>(value.real)) + "f";
    case SFT_FLOAT64:
      return real_text(value.real);
    case SFT_STRING:
      return string_literal(value.text);
    default:
      return natural_text(value.natural);
  }
}

std::string natural_text(std::uint64_t value) {
  const bool needs_suffix = value > std::uint64_t{std::numeric_limits<std::int64_t>::max()};
  return fmt::format("{}{}", value, needs_suffix ? "U" : "");
}

std::string initializer(const sft_member& member) {
  if (member.initial.is_set) return " = " + value_text(member.type, member.initial);
  std::string elements;
  for (const sft_value& value : std::span(member.initial_elements, member.initial_element_count)) {
    elements += (elements.empty() ? "" : ", ") + value_text(member.type, value);
  }
  return elements.empty() ? "{}" : " = {" + elements + "}";  // inner dimensions need no braces of their own
}

std::string string_literal(std::string_view text) { return quoted(text, '"'); }

}  // namespace sft::idl
