#include "message.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <span>

#include "enclosed.h"
#include "naming.h"
#include "spelling.h"

namespace sft::idl {
namespace {

/// The fields that points() of the view reads.
constexpr std::array<std::string_view, 7> cloud_fields{"height",     "width",    "fields", "is_bigendian",
                                                       "point_step", "row_step", "data"};

bool is_constant_of(const sft_declaration& declaration, std::string_view struct_name) {
  const std::string_view name = declaration.name;
  return declaration.kind == SFT_CONSTANT &&
         name == fmt::format("{}_Constants::{}", struct_name, last_name(name));
}

std::span<const sft_declaration> declarations(const sft_file& file) {
  return {file.declarations, file.declaration_count};
}

}  // namespace

Message make_message(const sft_file& file, const sft_declaration& declaration) {
  const std::string_view scoped = declaration.name;
  Message message{idl_name(file, scoped), type_name(scoped), qualified_type(scoped), {}, {}};

  std::vector<std::string_view> names;
  for (const sft_declaration& other : declarations(file)) {
    if (!is_constant_of(other, scoped)) continue;
    message.constants.push_back({&other, {}});
    names.push_back(last_name(other.name));
  }
  for (const sft_member& member : std::span(declaration.members, declaration.member_count)) {
    message.fields.push_back({&member, {}});
    names.push_back(member.name);
  }

  const std::vector<std::string> cpp_names = member_names(message.name, names);
  auto name = cpp_names.begin();
  for (Constant& constant : message.constants) constant.name = *name++;
  for (Field& field : message.fields) field.name = *name++;
  return message;
}

bool belongs_to_struct(const sft_file& file, const sft_declaration& constant) {
  return std::ranges::any_of(declarations(file), [&](const sft_declaration& other) {
    return other.kind == SFT_STRUCT && is_constant_of(constant, other.name);
  });
}

bool is_reservable(const Field& field) {
  return field.idl->type.is_sequence && field.idl->type.kind < SFT_STRING;
}

bool is_cloud(const Message& message) {
  if (message.idl_name != "sensor_msgs::msg::PointCloud2") return false;
  const auto has = [&](std::string_view name) {
    return std::ranges::any_of(message.fields, [&](const Field& field) { return field.idl->name == name; });
  };
  return std::ranges::all_of(cloud_fields, has) && !has("points");
}

bool has_loan_size(const Field& field) {
  const sft_type& type = field.idl->type;
  return is_reservable(field) || (is_structure(type) && is_single(type));
}

}  // namespace sft::idl
