// Splits a text into lines, and each line into code and comment.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace sft::msg {

/// One line. Its members refer to the original text.
struct Line {
  std::uint32_t number;      ///< the number of the line, from 1
  std::string_view code;     ///< the text before the comment, without spaces around it; may be empty
  std::string_view comment;  ///< the text of the comment after the '#'
  bool has_comment;
  bool is_indented;
  std::uint32_t comment_column;  ///< the column in which the comment begins, from 1
};

/// Normalizes `text`: all lines end with '\n', all other white space is spaces, and a byte order mark is
/// removed.
std::string with_plain_spaces(std::string_view text);

/// Iterates over the lines of a text with plain spaces. The text must outlive the iterator.
class Lines {
 public:
  /// `before` lines precede the text in the same file.
  explicit Lines(std::string_view text, std::uint32_t before = 0) : rest_(text), number_(before) {}
  std::optional<Line> next();

 private:
  std::string_view rest_;
  std::uint32_t number_;
};

std::string_view trimmed(std::string_view text);

}  // namespace sft::msg
