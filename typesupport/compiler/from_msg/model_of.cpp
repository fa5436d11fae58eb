#include "from_msg/model_of.h"

#include <fmt/format.h>

#include <algorithm>

#include "from_msg/layouts.h"
#include "from_msg/nested.h"

namespace sft::msg {
namespace {

std::string cpp_name(const TypeName& type) {
  return fmt::format("::{}::{}::{}", type.package, type.folder, type.name);
}

/// Returns the path of the file of a message or of a service.
std::string path_of(const TypeName& type, const Files& files) {
  return (files.root / (type.text() + "." + type.folder)).string();
}

}  // namespace

ModelOf::ModelOf(const Definition& definition, const Files& files) {
  file_.path = keep(path_of(definition.type, files));
  sources_.push_back(file_.path);
  add(definition, files);
  for (const auto& nested : files.nested) sources_.push_back(keep(nested.string()));
  finish();
}

ModelOf::ModelOf(const TypeName& service, const std::vector<Definition>& definitions, const Files& files) {
  file_.path = keep(path_of(service, files));
  sources_.push_back(file_.path);
  for (const Definition& definition : definitions) add(definition, files);
  for (const auto& nested : files.nested) sources_.push_back(keep(nested.string()));
  sft_declaration& declaration = declarations_.emplace_back();
  declaration.kind = SFT_SERVICE;
  declaration.name = keep(cpp_name(service));
  finish();
}

void ModelOf::add(const Definition& definition, const Files& files) {
  // Nested files may be below several roots, but all headers are below one root. All parts of a service are
  // in one file.
  for (const TypeName& nested : nested_types(definition)) {
    const std::string path = path_of(nested, files);
    const bool is_here = nested.folder == "srv";
    if (!is_here && std::ranges::none_of(includes_, [&](const char* known) { return known == path; }))
      includes_.push_back(keep(path));
  }
  add_constants(definition);
  add_struct(definition);
}

void ModelOf::finish() {
  file_.includes = includes_.data();
  file_.include_count = includes_.size();
  file_.sources = sources_.data();
  file_.source_count = sources_.size();
  file_.declarations = declarations_.data();
  file_.declaration_count = declarations_.size();
}

void ModelOf::add_constants(const Definition& definition) {
  for (const Constant& constant : definition.constants) {
    sft_declaration& declaration = declarations_.emplace_back();
    declaration.kind = SFT_CONSTANT;
    declaration.name = keep(fmt::format("{}_Constants::{}", cpp_name(definition.type), constant.name));
    declaration.type = type_of(constant.type);
    declaration.value = value_of(constant.value);
  }
}

void ModelOf::add_struct(const Definition& definition) {
  std::vector<sft_member>& members = members_.emplace_back();
  for (const Field& field : definition.fields) members.push_back(member_of(field));
  sft_declaration& declaration = declarations_.emplace_back();
  declaration.kind = SFT_STRUCT;
  declaration.name = keep(cpp_name(definition.type));
  declaration.members = members.data();
  declaration.member_count = members.size();
}

sft_member ModelOf::member_of(const Field& field) {
  sft_member member{};
  member.name = keep(field.name);
  member.type = type_of(field.type);
  if (!field.unit.empty()) member.unit = keep(field.unit);
  if (!field.layout.text.empty()) member.layout = keep(layout_text(field));
  if (field.initial.empty()) return member;
  if (field.type.is_single()) {
    member.initial = value_of(field.initial.front());
    return member;
  }
  std::vector<sft_value>& elements = initials_.emplace_back();
  for (const Value& value : field.initial) elements.push_back(value_of(value));
  member.initial_elements = elements.data();
  member.initial_element_count = elements.size();
  return member;
}

sft_type ModelOf::type_of(const Type& type) {
  sft_type result{};
  result.kind = type.kind;
  if (type.kind == SFT_STRUCTURE) result.name = keep(cpp_name(type.nested));
  result.string_bound = type.string_bound;
  result.is_sequence = type.is_sequence;
  result.bound = type.bound;
  if (type.array_size != 0) result.dimensions[result.dimension_count++] = type.array_size;
  return result;
}

sft_value ModelOf::value_of(const Value& value) {
  sft_value result{};
  result.is_set = true;
  if (const auto* boolean = std::get_if<bool>(&value)) result.boolean = *boolean;
  if (const auto* integer = std::get_if<std::int64_t>(&value)) result.integer = *integer;
  if (const auto* natural = std::get_if<std::uint64_t>(&value)) result.natural = *natural;
  if (const auto* real = std::get_if<double>(&value)) result.real = *real;
  if (const auto* text = std::get_if<std::string>(&value)) result.text = keep(*text);
  return result;
}

}  // namespace sft::msg
