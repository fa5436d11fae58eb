#include "from_msg/lines.h"

#include <algorithm>

namespace sft::msg {
namespace {

Line line_of(std::string_view text, std::uint32_t number) {
  const std::size_t mark = text.find('#');
  Line line{number, trimmed(text.substr(0, mark)), {}, mark != text.npos, text.starts_with(' '), 0};
  if (line.has_comment) {
    const std::size_t begin = std::min(text.find_first_not_of('#', mark), text.size());
    line.comment = text.substr(begin);
    line.comment_column = static_cast<std::uint32_t>(begin + 1);
  }
  return line;
}

}  // namespace

std::string_view trimmed(std::string_view text) {
  const std::size_t first = text.find_first_not_of(' ');
  return first == text.npos ? "" : text.substr(first, text.find_last_not_of(' ') - first + 1);
}

std::string with_plain_spaces(std::string_view text) {
  if (text.starts_with("\xEF\xBB\xBF")) text.remove_prefix(3);
  std::string result;
  result.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    const char c = text[i];
    if (c == '\r') {
      if (i + 1 == text.size() || text[i + 1] != '\n') result += '\n';
    } else {
      result += c == '\t' || c == '\v' || c == '\f' ? ' ' : c;
    }
  }
  return result;
}

std::optional<Line> Lines::next() {
  if (rest_.empty()) return {};
  const std::size_t end = std::min(rest_.find('\n'), rest_.size());
  const Line line = line_of(rest_.substr(0, end), ++number_);
  rest_.remove_prefix(std::min(end + 1, rest_.size()));
  return line;
}

}  // namespace sft::msg
