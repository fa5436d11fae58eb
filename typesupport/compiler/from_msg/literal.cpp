#include "from_msg/literal.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <limits>
#include <locale>
#include <optional>
#include <sstream>

#include "from_msg/lines.h"
#include "from_msg/string_literal.h"
#include "from_msg/type.h"
#include "from_msg/utf8.h"

namespace sft::msg {
namespace {

using Error = tl::unexpected<std::string>;
using Result = tl::expected<Value, std::string>;

Result parse_boolean(std::string_view text) {
  std::string lower(text);
  std::ranges::transform(lower, lower.begin(), [](char c) { return c >= 'A' && c <= 'Z' ? c + 32 : c; });
  if (lower == "true" || lower == "1") return true;
  if (lower == "false" || lower == "0") return false;
  return Error(fmt::format("{} is not a bool: expected true or false", shown(text)));
}

/// Removes the single underscores that may separate digits. Returns nothing if underscores are misplaced.
std::optional<std::string> without_separators(std::string_view digits) {
  if (digits.starts_with('_') || digits.ends_with('_') || digits.find("__") != digits.npos) return {};
  std::string result(digits);
  std::erase(result, '_');
  return result;
}

struct Sign {
  bool is_negative;
  std::string_view magnitude;
};

Sign split_sign(std::string_view text) {
  const bool has_sign = text.starts_with('-') || text.starts_with('+');
  return {text.starts_with('-'), text.substr(has_sign ? 1 : 0)};
}

/// Returns the base that the prefix of `digits` stands for, and removes the prefix.
int base_of(std::string_view& digits) {
  if (digits.size() < 2 || digits[0] != '0') return 10;
  const char letter = static_cast<char>(digits[1] | 0x20);
  const int base = letter == 'x' ? 16 : letter == 'o' ? 8 : letter == 'b' ? 2 : 10;
  if (base != 10) digits.remove_prefix(digits.substr(2).starts_with('_') ? 3 : 2);
  return base;
}

struct Range {
  std::int64_t least;
  std::uint64_t most;
};

Range range_of(sft_kind kind) {
  switch (kind) {
    case SFT_INT8:
      return {INT8_MIN, INT8_MAX};
    case SFT_INT16:
      return {INT16_MIN, INT16_MAX};
    case SFT_INT32:
      return {INT32_MIN, INT32_MAX};
    case SFT_INT64:
      return {INT64_MIN, INT64_MAX};
    case SFT_UINT16:
      return {0, UINT16_MAX};
    case SFT_UINT32:
      return {0, UINT32_MAX};
    case SFT_UINT64:
      return {0, UINT64_MAX};
    default:
      return {0, UINT8_MAX};
  }
}

Result parse_integer(sft_kind kind, std::string_view text) {
  const Range range = range_of(kind);
  auto [is_negative, digits] = split_sign(text);
  const int base = base_of(digits);
  const auto plain = without_separators(digits);
  std::uint64_t magnitude = 0;
  const char* const end = plain ? plain->data() + plain->size() : nullptr;
  const auto [stop, error] =
      plain ? std::from_chars(plain->data(), end, magnitude, base) : std::from_chars_result{nullptr, {}};
  if (!plain || stop != end || error == std::errc::invalid_argument) {
    return Error(
        fmt::format("{} is not an integer: expected one such as -42, 0xFF, 0o17 or 0b101", shown(text)));
  }
  // For negative numbers, the limit is the magnitude of the lowest value.
  const std::uint64_t most =
      is_negative ? std::uint64_t{0} - static_cast<std::uint64_t>(range.least) : range.most;
  if (error != std::errc() || magnitude > most) {
    return Error(fmt::format("{} is out of range: expected {} to {}", shown(text), range.least, range.most));
  }
  if (range.least == 0) return magnitude;
  return static_cast<std::int64_t>(is_negative ? std::uint64_t{0} - magnitude : magnitude);
}

/// Returns true for digits, point and exponent. The check is needed because from_chars accepts more, such
/// as "inf".
bool is_decimal(std::string_view digits) {
  return digits.find_first_not_of("0123456789.eE+-") == digits.npos &&
         digits.find_first_of("0123456789") != digits.npos && !digits.starts_with('-');
}

Result parse_real(sft_kind kind, std::string_view text) {
  const auto [is_negative, digits] = split_sign(text);
  const auto plain = without_separators(digits);
  double value = 0;
  const char* const end = plain ? plain->data() + plain->size() : nullptr;
  const auto [stop, error] = plain && is_decimal(*plain) ? std::from_chars(plain->data(), end, value)
                                                         : std::from_chars_result{nullptr, {}};
  if (stop == nullptr || stop != end || error == std::errc::invalid_argument) {
    return Error(
        fmt::format("{} is not a number: expected one such as -1.5 or 2e-3; infinity and NaN "
                    "cannot be written",
                    shown(text)));
  }
  if (error == std::errc::result_out_of_range) {
    // Parses once more, to distinguish 0 (too small) from infinity (too large).
    std::istringstream again(*plain);
    again.imbue(std::locale::classic());
    if (!(again >> value)) value = std::numeric_limits<double>::infinity();
  }
  const bool is_float = kind == SFT_FLOAT32;
  if (std::isinf(is_float ? static_cast<float>(value) : value)) {
    return Error(
        fmt::format("{} is out of range: expected a {} of at most {:g}", shown(text), spelling_of(kind),
                    is_float ? std::numeric_limits<float>::max() : std::numeric_limits<double>::max()));
  }
  return is_negative ? -value : value;
}

Result parse_bounded_string(const Type& type, std::string_view text) {
  auto result = parse_string(text);
  if (!result) return Error(result.error());
  if (type.string_bound != 0 && result->size() > type.string_bound) {
    return Error(fmt::format("{} takes {} bytes: expected at most {}, the string's bound", shown(text),
                             result->size(), type.string_bound));
  }
  return *std::move(result);
}

Result parse_element(const Type& type, std::string_view text) {
  switch (type.kind) {
    case SFT_BOOLEAN:
      return parse_boolean(text);
    case SFT_FLOAT32:
    case SFT_FLOAT64:
      return parse_real(type.kind, text);
    case SFT_STRING:
      return parse_bounded_string(type, text);
    case SFT_STRUCTURE:
      return Error("fields of a message type have no defaults of their own: give them in that message");
    default:
      return parse_integer(type.kind, text);
  }
}

/// Returns the length of the first element of `text`. A comma in quotes does not end an element. Returns
/// npos if the closing quote is missing.
std::size_t element_length(std::string_view text) {
  std::size_t from = 0;
  if (text.starts_with('"') || text.starts_with('\'')) from = quoted_end(text);
  return from == text.npos ? text.npos : std::min(text.find(',', from), text.size());
}

tl::expected<std::vector<Value>, std::string> parse_list(const Type& type, std::string_view list) {
  std::vector<Value> values;
  for (std::string_view rest = trimmed(list); !rest.empty();) {
    const std::size_t length =
        type.kind == SFT_STRING ? element_length(rest) : std::min(rest.find(','), rest.size());
    const std::string_view text = trimmed(rest.substr(0, length));
    if (text.empty()) return Error(fmt::format("element {} is missing", values.size()));
    auto value = parse_element(type, text);
    if (!value) return Error(fmt::format("element {}: {}", values.size(), value.error()));
    values.push_back(*std::move(value));
    rest.remove_prefix(length);
    if (rest.empty()) break;
    rest = trimmed(rest.substr(1));
    if (rest.empty() && type.kind != SFT_STRING)
      return Error(fmt::format("element {} is missing", values.size()));
  }
  return values;
}

tl::expected<void, std::string> check_count(const Type& type, std::size_t count) {
  if (type.array_size != 0 && count != type.array_size) {
    return Error(fmt::format("{} elements: expected {}, the size of the array", count, type.array_size));
  }
  if (type.bound != 0 && count > type.bound) {
    return Error(fmt::format("{} elements: expected at most {}, the bound", count, type.bound));
  }
  return {};
}

}  // namespace

tl::expected<std::vector<Value>, std::string> parse_values(const Type& type, std::string_view text) {
  if (type.is_single()) {
    auto value = parse_element(type, text);
    if (!value) return Error(value.error());
    return std::vector{*std::move(value)};
  }
  if (type.kind == SFT_STRUCTURE) return Error(parse_element(type, text).error());
  if (text.size() < 2 || !text.starts_with('[') || !text.ends_with(']')) {
    return Error(fmt::format("{} is not a list: expected one such as [1, 2, 3]", shown(text)));
  }
  auto values = parse_list(type, text.substr(1, text.size() - 2));
  if (!values) return values;
  if (const auto fits = check_count(type, values->size()); !fits) return Error(fits.error());
  return values;
}

}  // namespace sft::msg
