// The results of the parser for texts of .msg files.
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <string_view>

#include "from_msg/parse.h"

namespace sft::msg::test {

inline const TypeName example{"my_msgs", "Example"};

/// Returns the definition in `text`. If there is none, the test fails, and the result is empty.
inline Definition parsed(std::string_view text) {
  auto result = parse(text, example);
  if (result) return *std::move(result);
  ADD_FAILURE() << text << ": " << result.error().front().text;
  return {};
}

/// Returns the problems of `text`, one per line: "LINE MEMBER: TEXT", followed by the column if it is known.
/// Returns "" if there are no problems.
inline std::string problems(std::string_view text, const TypeName& name = example) {
  std::string lines;
  const auto result = parse(text, name);
  if (result) return lines;
  for (const Problem& problem : result.error()) {
    lines += lines.empty() ? "" : "\n";
    lines += std::to_string(problem.line) + " " + problem.member + ": " + problem.text;
    if (problem.column != 0) lines += " (column " + std::to_string(problem.column) + ")";
  }
  return lines;
}

}  // namespace sft::msg::test
