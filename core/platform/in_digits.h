// Formats a number for people, independently of the locale of the program.
#pragma once

#include <charconv>
#include <string>

namespace sft::core {

/// Returns the number with at most six digits: "0.0001" or "1e+06".
inline std::string in_digits(double value) {
  char text[32];
  const auto end = std::to_chars(text, text + sizeof text, value, std::chars_format::general, 6).ptr;
  return {text, end};
}

}  // namespace sft::core
