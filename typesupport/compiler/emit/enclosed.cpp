#include "enclosed.h"

#include <fmt/format.h>

#include <span>
#include <stdexcept>

#include "naming.h"

namespace sft::idl {
namespace {

/// Returns the names of which "my::robot" consists. If a name is missing, the result has an empty name in
/// its place, so that it is refused.
std::vector<std::string_view> names_in(std::string_view outer) {
  std::vector<std::string_view> names;
  for (std::size_t at = outer.find("::"); at != outer.npos; at = outer.find("::")) {
    names.push_back(outer.substr(0, at));
    outer.remove_prefix(at + 2);
  }
  names.push_back(outer);
  return names;
}

}  // namespace

Enclosed::Enclosed(const sft_file& file, std::string_view outer)
    : prefix_(outer.empty() ? "" : fmt::format("::{}", outer)), file_(file) {
  if (outer.empty()) return;
  for (const std::string_view name : names_in(outer)) {
    if (!is_plain_namespace(name)) {
      throw std::runtime_error(
          fmt::format("the namespace '{}': expected names as in my::robot, and '{}' is a word of C++, 'std', "
                      "'sft', a macro, or no name",
                      outer, name));
    }
  }
  for (sft_declaration declaration : std::span(file.declarations, file.declaration_count)) {
    enclose(declaration.name);
    enclose(declaration.type.name);
    std::vector<sft_member>& members =
        members_.emplace_back(declaration.members, declaration.members + declaration.member_count);
    for (sft_member& member : members) enclose(member.type.name);
    declaration.members = members.data();
    declarations_.push_back(declaration);
  }
  file_.declarations = declarations_.data();
  file_.outer_namespace = prefix_.c_str();
}

void Enclosed::enclose(const char*& scoped) {
  if (scoped != nullptr) scoped = names_.emplace_back(prefix_ + scoped).c_str();
}

std::string_view idl_name(const sft_file& file, std::string_view scoped) {
  const std::string_view outer = file.outer_namespace == nullptr ? "" : file.outer_namespace;
  return scoped.substr(outer.size() + 2);
}

std::string folder_of_namespace(std::string_view outer) {
  std::string folder;
  if (outer.empty()) return folder;
  for (const std::string_view name : names_in(outer)) folder += std::string(name) + "/";
  return folder;
}

}  // namespace sft::idl
