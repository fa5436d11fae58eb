#include "table.h"

#include <span>

#include "enclosed.h"
#include "naming.h"
#include "spelling.h"

namespace sft::idl {
namespace {

/// Returns the sft::detail::MemberOptions of a field after a comma, or nothing.
std::string options(const sft_member& member) {
  std::string given;
  const auto add = [&](std::string_view option, const std::string& value) {
    given += fmt::format("{}.{} = {}", given.empty() ? "" : ", ", option, value);
  };
  if (member.type.bound != 0) add("bound", fmt::to_string(member.type.bound));
  if (member.type.string_bound != 0) add("string_bound", fmt::to_string(member.type.string_bound));
  if (member.is_key) add("key", "true");
  if (member.unit != nullptr) add("unit", string_literal(member.unit));
  if (member.layout != nullptr) add("layout", string_literal(member.layout));
  return given.empty() ? "" : ", {" + given + "}";
}

void emit_row(Code& code, const Field& field) {
  const sft_member& member = *field.idl;
  code.line(
      "      sft::detail::member<decltype(T::{0}), decltype(S_::{0})>(\"{1}\", {2}, offsetof(S_, {0}){3}),",
      field.name, member.name, kind_name(member.type.kind), options(member));
}

}  // namespace

void emit_enum_table(Code& code, const sft_file& file, const sft_declaration& enumeration) {
  code.line("template <>");
  code.line("struct sft::detail::EnumTable<{}> {{", qualified_type(enumeration.name));
  code.line("  static constexpr std::array enumerators{{");
  for (const sft_enumerator& e : std::span(enumeration.enumerators, enumeration.enumerator_count))
    code.line("      sft::detail::Enumerator{{\"{}\", {}}},", e.name, natural_text(e.value));
  code.line("  }};");
  code.line("  static constexpr sft::EnumType type{{\"{}\", {}, enumerators}};",
            idl_name(file, enumeration.name), enumeration.kind == SFT_BITMASK);
  code.line("}};");
  code.blank();
}

void emit_table(Code& code, const Message& message) {
  code.line("template <>");
  code.line("struct sft::detail::TypeTable<{}> {{", message.qualified);
  code.line("  using T = {};", message.qualified);
  code.line("  template <class S_>");
  code.line("  static constexpr std::array members_in{{");
  for (const Field& field : message.fields) emit_row(code, field);
  code.line("  }};");
  code.line("  static constexpr auto& members = members_in<T>;");
  code.line("  static constexpr sft::StructType type{{\"{}\", members}};", message.idl_name);
  code.line("}};");
  code.blank();
}

}  // namespace sft::idl
