#include "tools/sft/topic_selection.h"

#include <algorithm>
#include <regex>

namespace sft::tool {

namespace {

/// Returns the position of the brace that closes the first brace of the text; npos if there is none.
std::size_t closing_brace(std::string_view text) {
  int depth = 0;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] == '{') ++depth;
    if (text[i] == '}' && --depth == 0) return i;
  }
  return text.npos;
}

/// Returns true if the text names several fields.
bool has_several(std::string_view fields) {
  int depth = 0;
  return std::ranges::any_of(fields, [&](char c) {
    depth += c == '{' || c == '[' ? 1 : c == '}' || c == ']' ? -1 : 0;
    return c == ',' && depth == 0;
  });
}

/// Changes "every 2" to "every 2nd", because people often leave out the ending.
std::string with_ordinals(const std::string& gate) {
  static const std::regex bare(R"(\bevery\s+(\d+)(?=\s*($|\)|or\b|and\b|at\b)))");
  return std::regex_replace(gate, bare, "every $1th");
}

}  // namespace

Result<TopicSelection> parse_topic_selection(std::string_view text) {
  const std::size_t end = std::min(text.find_first_of("{@"), text.size());
  TopicSelection parsed{.topic = std::string(text.substr(text.starts_with('/') ? 1 : 0,
                                                         end - (text.starts_with('/') ? 1 : 0)))};
  const auto wrong = [&](const char* what) {
    return fail(Errc::invalid_argument,
                "'" + std::string(text) + "': " + what +
                    "; write TOPIC, TOPIC{FIELDS}, TOPIC@CONDITION or TOPIC{FIELDS}@CONDITION");
  };
  if (parsed.topic.empty()) return wrong("the topic is missing");
  std::string_view rest = text.substr(end);
  if (rest.starts_with('{')) {
    const std::size_t close = closing_brace(rest);
    if (close == rest.npos) return wrong("a brace is not closed");
    parsed.text = rest.substr(1, close - 1);
    if (parsed.text.find_first_not_of(' ') == parsed.text.npos)
      return wrong("there is nothing in the braces");
    rest.remove_prefix(close + 1);
    if (rest.starts_with('[')) {  // the part may be after the braces or within them
      const std::size_t end_of_part = rest.find(']');
      if (end_of_part == rest.npos) return wrong("a bracket is not closed");
      if (has_several(parsed.text)) return wrong("[...] behind the braces is for a single field within");
      parsed.text += rest.substr(0, end_of_part + 1);
      rest.remove_prefix(end_of_part + 1);
    }
  }
  if (rest.empty()) return parsed;
  if (!rest.starts_with('@')) return wrong("behind the braces comes @ or nothing");
  parsed.text += " @ " + with_ordinals(std::string(rest.substr(1)));
  return parsed;
}

}  // namespace sft::tool
