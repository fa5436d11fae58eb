#include "from_msg/string_literal.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <optional>

#include "from_msg/utf8.h"

namespace sft::msg {
namespace {

using Error = tl::unexpected<std::string>;

bool begins_with_quote(std::string_view text) { return text.starts_with('"') || text.starts_with('\''); }

/// Resolves the escapes of a string whose quotes have been removed.
class Unescaping {
 public:
  explicit Unescaping(std::string_view text) : rest_(text) {}

  tl::expected<std::string, std::string> run() {
    while (!rest_.empty()) {
      const std::size_t mark = std::min(rest_.find('\\'), rest_.size());
      result_ += rest_.substr(0, mark);
      rest_.remove_prefix(mark);
      if (rest_.empty()) break;
      if (!escape()) {
        return Error(fmt::format("bad escape at {}: write \\\\ for a backslash", shown(rest_)));
      }
    }
    return result_;
  }

 private:
  /// Resolves the escape at the beginning of `rest_`, and removes it.
  bool escape() {
    constexpr std::string_view names = "nrtabfv\\\"'";
    constexpr std::string_view meanings = "\n\r\t\a\b\f\v\\\"'";
    if (rest_.size() < 2) return false;
    const char name = rest_[1];
    if (const std::size_t which = names.find(name); which != names.npos) {
      result_ += meanings[which];
      rest_.remove_prefix(2);
      return true;
    }
    if (name == 'x') return hexadecimal(2, true);
    if (name == 'u') return hexadecimal(4, false);
    if (name == 'U') return hexadecimal(8, false);
    if (name >= '0' && name <= '7') return octal();
    result_ += '\\';  // a backslash before any other character stands for itself, as in ROS 2
    rest_.remove_prefix(1);
    return true;
  }

  bool hexadecimal(std::size_t digits, bool is_byte) {
    const auto code = number(rest_.substr(2, digits), 16);
    if (!code || rest_.size() < 2 + digits) return false;
    rest_.remove_prefix(2 + digits);
    if (!is_byte) return append_utf8(*code, result_);
    result_ += static_cast<char>(*code);
    return true;
  }

  bool octal() {
    const std::size_t end = std::min(rest_.find_first_not_of("01234567", 1), std::size_t{4});
    const auto code = number(rest_.substr(1, std::min(end, rest_.size()) - 1), 8);
    if (!code || *code > 0xFF) return false;
    rest_.remove_prefix(std::min(end, rest_.size()));
    result_ += static_cast<char>(*code);
    return true;
  }

  static std::optional<std::uint32_t> number(std::string_view digits, int base) {
    std::uint32_t value = 0;
    const char* const end = digits.data() + digits.size();
    const auto [stop, error] = std::from_chars(digits.data(), end, value, base);
    return error == std::errc() && stop == end ? std::optional(value) : std::nullopt;
  }

  std::string_view rest_;
  std::string result_;
};

tl::expected<std::string_view, std::string> without_quotes(std::string_view text) {
  if (!begins_with_quote(text)) return text;
  const std::size_t end = quoted_end(text);
  if (end == text.npos) {
    return Error(
        fmt::format("the quote that ends {} is missing: '#' begins a comment even in quotes, where "
                    "\\x23 means it",
                    shown(text)));
  }
  if (end != text.size()) {
    return Error(fmt::format("{} goes on behind the quote that ends it: write \\{} for a quote inside",
                             shown(text), text[0]));
  }
  return text.substr(1, text.size() - 2);
}

}  // namespace

std::size_t quoted_end(std::string_view text) {
  for (std::size_t i = 1; i < text.size(); ++i) {
    if (text[i] == text[0]) return i + 1;
    if (text[i] == '\\') ++i;
  }
  return text.npos;
}

tl::expected<std::string, std::string> parse_string(std::string_view text) {
  const auto inside = without_quotes(text);
  if (!inside) return Error(inside.error());
  auto result = Unescaping(*inside).run();
  if (!result) return result;
  if (result->find('\0') != result->npos) return Error("a string cannot hold a NUL: leave it out");
  if (find_invalid_utf8(*result) != result->npos) {
    return Error(fmt::format("{} is not UTF-8: write \\u00E9 for the character U+00E9", shown(text)));
  }
  return result;
}

}  // namespace sft::msg
