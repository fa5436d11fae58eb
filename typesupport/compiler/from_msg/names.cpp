#include "from_msg/names.h"

#include <algorithm>

namespace sft::msg {
namespace {

bool is_lower(char c) { return c >= 'a' && c <= 'z'; }
bool is_upper(char c) { return c >= 'A' && c <= 'Z'; }
bool is_digit(char c) { return c >= '0' && c <= '9'; }

template <class IsLetter>
bool is_snake_case(std::string_view name, IsLetter is_letter) {
  return !name.empty() && is_letter(name.front()) && name.back() != '_' && name.find("__") == name.npos &&
         std::ranges::all_of(name, [&](char c) { return is_letter(c) || is_digit(c) || c == '_'; });
}

}  // namespace

bool is_package_name(std::string_view name) { return is_snake_case(name, is_lower); }

bool is_field_name(std::string_view name) { return is_snake_case(name, is_lower); }

bool is_constant_name(std::string_view name) { return is_snake_case(name, is_upper); }

bool is_message_name(std::string_view name) {
  constexpr std::string_view prefix = "Sample_";
  if (name.starts_with(prefix)) name.remove_prefix(prefix.size());
  for (const std::string_view suffix : {"_Request", "_Response", "_Goal", "_Result", "_Feedback"}) {
    if (name.ends_with(suffix)) name.remove_suffix(suffix.size());
  }
  return !name.empty() && is_upper(name.front()) &&
         std::ranges::all_of(name, [](char c) { return is_lower(c) || is_upper(c) || is_digit(c); });
}

}  // namespace sft::msg
