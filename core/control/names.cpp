#include "core/control/names.h"

#include "core/control/control.h"

namespace sft::core {

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

std::string_view fault_of_topic(std::string_view topic) {
  if (topic == "/") return "ends with a slash";
  if (const std::string_view fault = fault_of_name(without_slash(topic)); !fault.empty()) return fault;
  if (topic.back() == ' ' || without_slash(topic).starts_with(' ')) return "begins or ends with a blank";
  if (topic.find('~') != std::string_view::npos) return "has a '~' in it, which stands for nothing here";
  if (topic.find("//") != std::string_view::npos) return "has nothing between two slashes";
  if (topic.back() == '/') return "ends with a slash";
  return {};
}

std::string_view without_slash(std::string_view topic) {
  return topic.starts_with('/') ? topic.substr(1) : topic;
}

}  // namespace sft::core
