#include "core/names/names.h"

#include <algorithm>

namespace sft::core {

namespace {

bool is_digit(char c) { return c >= '0' && c <= '9'; }

/// Returns true if a topic may contain the character. (The name of a node has no slash.)
bool is_of_words(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || is_digit(c) || c == '_' || c == '/';
}

}  // namespace

std::string_view fault_of_name(std::string_view name) {
  if (name.empty()) return "is empty";
  static_assert(name_bytes_max == 255, "the text below says so");
  if (name.size() > name_bytes_max) return "has more than 255 bytes";
  while (!name.empty()) {
    const Character c = first_of(name);
    if (c.bytes == 0) return "is not UTF-8";
    if (acts_on_terminals(c.code)) return "has a control character in it";
    name.remove_prefix(c.bytes);
  }
  return {};
}

std::string_view fault_of_announced_topic(std::string_view topic) {
  if (topic == "/") return "ends with a slash";
  if (const std::string_view fault = fault_of_name(without_slash(topic)); !fault.empty()) return fault;
  if (topic.back() == ' ' || without_slash(topic).starts_with(' ')) return "begins or ends with a blank";
  if (topic.find('~') != std::string_view::npos) return "has a '~' in it, which stands for nothing here";
  if (topic.find("//") != std::string_view::npos) return "has nothing between two slashes";
  if (topic.back() == '/') return "ends with a slash";
  return {};
}

std::string_view fault_of_topic(std::string_view topic) {
  if (const std::string_view fault = fault_of_announced_topic(topic); !fault.empty()) return fault;
  constexpr std::size_t most = 246;  // RMW_TOPIC_MAX_NAME_LENGTH, without the leading slash
  if (without_slash(topic).size() > most) return "has more than 246 characters, the most that ROS 2 allows";
  if (!std::ranges::all_of(topic, is_of_words)) {
    return "has a character in it that is no letter of a to z, no digit, no '_' and no '/': ROS 2 allows no "
           "others in topics, services and namespaces";
  }
  const auto begins_with_digit = [](char before, char c) { return before == '/' && is_digit(c); };
  if (is_digit(topic.front()) || std::ranges::adjacent_find(topic, begins_with_digit) != topic.end())
    return "has a part that begins with a digit, which ROS 2 does not allow";
  return {};
}

std::string_view fault_of_namespace(std::string_view name) {
  if (name.empty() || name == "/") return {};
  constexpr std::size_t most = 244;  // RMW_NAMESPACE_MAX_LENGTH, without the leading slash
  if (without_slash(name).size() > most) return "has more than 244 characters, the most that ROS 2 allows";
  return fault_of_topic(name);
}

std::string_view fault_of_node(std::string_view name) {
  if (name.find('/') != name.npos) return "has a slash in it, which only the namespace of a node may have";
  if (const std::string_view fault = fault_of_name(name); !fault.empty()) return fault;
  if (!std::ranges::all_of(name, is_of_words)) {
    return "has a character in it that is no letter of a to z, no digit and no '_': ROS 2 allows no others "
           "in "
           "names of nodes";
  }
  if (is_digit(name.front())) return "begins with a digit, which ROS 2 does not allow";
  return {};
}

std::string_view without_slash(std::string_view topic) {
  return topic.starts_with('/') ? topic.substr(1) : topic;
}

}  // namespace sft::core
