#include "owned.h"

#include <algorithm>
#include <array>
#include <span>

#include "naming.h"
#include "spelling.h"

namespace sft::idl {
namespace {

void emit_constant(Code& code, const sft_declaration& constant) {
  code.line("inline constexpr {} {} = {};", constant_type(constant.type),
            identifier(last_name(constant.name)), value_text(constant.type, constant.value));
}

void emit_alias(Code& code, const sft_declaration& alias) {
  code.line("using {} = {};", type_name(alias.name), owned_type(alias.type));
}

/// Writes the enum class of an enumeration or of a bitmask.
void emit_enumeration(Code& code, const sft_declaration& enumeration) {
  code.line("enum class {} : {} {{", type_name(enumeration.name), element_type(enumeration.type));
  for (const sft_enumerator& e : std::span(enumeration.enumerators, enumeration.enumerator_count)) {
    code.line("  {} = {},", identifier(e.name), natural_text(e.value));
  }
  code.line("}};");
}

/// Writes the same operators as the standard library's bitmask types have. They work on the integers,
/// because enumerators name single bits only.
void emit_flag_operators(Code& code, const sft_declaration& bitmask) {
  const std::string type = qualified_type(bitmask.name);
  const std::string integer = element_type(bitmask.type);
  for (const char* op : {"|", "&", "^"}) {
    code.line("constexpr {0} operator{1}({0} a, {0} b) {{", type, op);
    code.line("  return static_cast<{0}>(static_cast<{1}>(a) {2} static_cast<{1}>(b));", type, integer, op);
    code.line("}}");
  }
  code.line("constexpr {0} operator~({0} a) {{ return static_cast<{0}>(~static_cast<{1}>(a)); }}", type,
            integer);
}

void emit_members(Code& code, const Message& message) {
  for (const Constant& constant : message.constants) {
    code.line("  static constexpr {} {} = {};", constant_type(constant.idl->type), constant.name,
              value_text(constant.idl->type, constant.idl->value));
  }
  if (!message.constants.empty()) code.blank();
  for (const Field& field : message.fields) {
    code.line("  {} {}{};", owned_type(field.idl->type), field.name, initializer(*field.idl));
  }
}

void emit_loan_sizes(Code& code, const Message& message) {
  if (std::ranges::none_of(message.fields, has_loan_size)) {
    code.line("  struct LoanSizes {{}};");
    return;
  }
  code.line("  struct LoanSizes {{");
  for (const Field& field : message.fields) {
    if (!has_loan_size(field)) continue;
    code.line(
        "    {} {}{{}};",
        is_reservable(field) ? "std::optional<std::uint32_t>" : element_type(field.idl->type) + "::LoanSizes",
        field.name);
  }
  code.line("  }};");
}

void emit_struct(Code& code, const Message& message) {
  code.line("struct {} {{", message.name);
  emit_members(code, message);
  code.blank();
  code.line("  bool operator==(const {}&) const = default;", message.name);
  code.blank();
  code.line("  template <class Root_ = {}, std::size_t First_ = 0>", message.name);
  code.line("  struct Fields;");
  code.line("  using Field = Fields<>;");
  code.line("  template <class Place_>");
  code.line("  class View;");
  emit_loan_sizes(code, message);
  code.line("  template <class Loaned_>");
  code.line("  class LoanView;");
  code.line("}};");
}

/// Writes the struct that names the messages of a service.
void emit_service(Code& code, const sft_declaration& service) {
  constexpr std::array parts = std::to_array<std::string_view>({"Request", "Response", "Call", "Reply"});
  const std::string_view name = last_name(service.name);
  const bool is_taken = std::ranges::find(parts, name) != parts.end();
  code.line("struct {}{} {{", type_name(service.name), is_taken ? "_" : "");
  for (const std::string_view part : parts) code.line("  using {0} = {1}_{0};", part, name);
  code.line("}};");
}

/// Opens and closes namespaces. Writes blank lines between declarations, except within series of constants
/// or aliases.
class Layout {
 public:
  explicit Layout(Code& code) : code_(code) {}

  void before(const sft_declaration& declaration) {
    const bool is_one_line = declaration.kind == SFT_CONSTANT || declaration.kind == SFT_ALIAS;
    if (previous_ != nullptr && (!is_one_line || previous_->kind != declaration.kind)) code_.blank();
    enter(namespace_of(declaration.name));
    previous_ = &declaration;
  }
  void end() {
    if (previous_ != nullptr) code_.blank();
    enter("");
  }

 private:
  void enter(const std::string& wanted) {
    if (wanted == current_) return;
    if (!current_.empty()) code_.line("}}  // namespace {}\n", current_);
    if (!wanted.empty()) code_.line("namespace {} {{\n", wanted);
    current_ = wanted;
  }

  Code& code_;
  std::string current_;
  const sft_declaration* previous_ = nullptr;
};

}  // namespace

void emit_owned(Code& code, const sft_file& file, const std::vector<Message>& messages) {
  Layout layout(code);
  auto message = messages.begin();
  for (const sft_declaration& declaration : std::span(file.declarations, file.declaration_count)) {
    if (declaration.kind == SFT_CONSTANT && belongs_to_struct(file, declaration)) continue;
    layout.before(declaration);
    switch (declaration.kind) {
      case SFT_CONSTANT:
        emit_constant(code, declaration);
        break;
      case SFT_ALIAS:
        emit_alias(code, declaration);
        break;
      case SFT_ENUMERATION:
        emit_enumeration(code, declaration);
        break;
      case SFT_BITMASK:
        emit_enumeration(code, declaration);
        emit_flag_operators(code, declaration);
        break;
      case SFT_STRUCT:
        emit_struct(code, *message++);
        break;
      case SFT_SERVICE:
        emit_service(code, declaration);
        break;
    }
  }
  layout.end();
}

}  // namespace sft::idl
