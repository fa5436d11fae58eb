// A text as lines, what they say apart from comments.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace sft::msg {

/// Refers to the text.
struct Line {
  std::uint32_t number;      ///< from 1
  std::string_view code;     ///< before the comment, without spaces around it; may be empty
  std::string_view comment;  ///< behind all the '#' that begin it
  bool has_comment;
  bool is_indented;
};

/// `text` with nothing but '\n' at the end of lines and nothing but spaces for white space; without a byte
/// order mark.
std::string with_plain_spaces(std::string_view text);

/// Goes through a text with plain spaces, which must outlive it.
class Lines {
 public:
  explicit Lines(std::string_view text) : rest_(text) {}
  std::optional<Line> next();

 private:
  std::string_view rest_;
  std::uint32_t number_ = 0;
};

std::string_view trimmed(std::string_view text);

}  // namespace sft::msg
