#include "tools/sft/msg_text.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string_view>
#include <vector>

namespace sft::tool {

namespace {

using Member = StructType::Member;

std::string element_text(const Member& m) {
  static constexpr std::array names{"bool",  "byte",   "char",  "int8",   "uint8",   "int16",   "uint16",
                                    "int32", "uint32", "int64", "uint64", "float32", "float64", "string"};
  if (m.kind == Member::Kind::structure) return msg_name(m.type->name);
  std::string text = names[static_cast<std::size_t>(m.kind)];
  if (m.kind == Member::Kind::string && m.string_bound != 0) text += fmt::format("<={}", m.string_bound);
  return text;
}

std::string shape_text(const Member& m) {
  if (m.shape == Member::Shape::single) return "";
  if (m.shape == Member::Shape::array) return fmt::format("[{}]", m.count);
  return m.bound == 0 ? "[]" : fmt::format("[<={}]", m.bound);
}

std::string comment_of(const Member& m) {
  std::string text;
  if (!m.unit.empty()) text += fmt::format(" [{}]", m.unit);
  if (m.key) text += " key";
  if (m.enumeration != nullptr) {
    text += fmt::format(" {}:", msg_name(m.enumeration->name));
    for (const EnumType::Enumerator& e : m.enumeration->enumerators)
      text += fmt::format(" {}={}", e.name, e.value);
  }
  return text.empty() ? "" : "  #" + text;
}

std::string members_text(const StructType& type, const ConstantsOf& constants_of) {
  std::string text = constants_of(type);
  for (const Member& m : type.members)
    text += fmt::format("{}{} {}{}\n", element_text(m), shape_text(m), m.name, comment_of(m));
  return text;
}

/// Adds the types of the members to `found`. If the function is called for each type in the list in turn,
/// all types are listed breadth first, as `ros2 interface show` does.
void add_nested(const StructType& type, std::vector<const StructType*>& found) {
  for (const Member& m : type.members) {
    if (m.type == nullptr) continue;
    const auto same_name = [&](const StructType* known) { return known->name == m.type->name; };
    if (std::ranges::none_of(found, same_name)) found.push_back(m.type);
  }
}

std::string with_slashes(std::string text, std::string_view instead_of) {
  for (std::size_t at = text.find(instead_of); at != std::string::npos; at = text.find(instead_of))
    text.replace(at, instead_of.size(), "/");
  return text;
}

}  // namespace

std::string msg_name(std::string_view name) {
  return with_slashes(with_slashes(std::string(name), "::msg::"), "::");
}

std::string ros_name(std::string_view name) { return with_slashes(std::string(name), "::"); }

std::string msg_text(const StructType& type, const ConstantsOf& constants_of) {
  std::vector<const StructType*> types{&type};
  for (std::size_t i = 0; i < types.size(); ++i) add_nested(*types[i], types);
  std::string text = members_text(type, constants_of);
  for (std::size_t i = 1; i < types.size(); ++i) {
    text += std::string(80, '=') + fmt::format("\nMSG: {}\n", msg_name(types[i]->name)) +
            members_text(*types[i], constants_of);
  }
  return text;
}

}  // namespace sft::tool
