#include "fields.h"

#include "spelling.h"

namespace sft::idl {
namespace {

/// Returns the node type of field number `index`.
std::string node_type(const sft_type& type, std::size_t index) {
  if (!is_structure(type)) return fmt::format("typename Of_::template Leaf<{}>", index);
  const std::string element = element_type(type);
  if (is_single(type)) return fmt::format("{}::Fields<Root_, Of_::template first<{}>>", element, index);
  return fmt::format("sft::detail::{}<{}, Root_, Of_::template first<{}>>",
                     type.is_sequence ? "SequenceFields" : "ArrayFields", element, index);
}

}  // namespace

void emit_fields(Code& code, const Message& message) {
  code.line("template <class Root_, std::size_t First_>");
  code.line("struct {}::Fields : sft::detail::FieldsOf<Root_, First_, {}> {{", message.class_head(),
            message.qualified);
  code.line("  using Of_ = sft::detail::FieldsOf<Root_, First_, {}>;", message.qualified);
  for (std::size_t i = 0; i < message.fields.size(); ++i) {
    const Field& field = message.fields[i];
    code.line("  static constexpr {} {}{{}};", node_type(field.idl->type, i), field.name);
  }
  code.line("}};");
  code.blank();
}

}  // namespace sft::idl
