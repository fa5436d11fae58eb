#include "views.h"

#include <algorithm>

#include "spelling.h"

namespace sft::idl {
namespace {

void emit_getter(Code& code, const Field& field, std::size_t index) {
  const sft_type& type = field.idl->type;
  code.line("  auto {}() const requires sft::field_is_in_declared_mask<Place_, {}> {{", field.name, index);
  code.line("    return at_.template get<{}{}>();", index,
            type.name == nullptr ? "" : ", " + element_type(type));
  code.line("  }}");
}

void emit_reservations(Code& code, const Message& message) {
  const auto count = std::ranges::count_if(message.fields, is_reservable);
  code.line("  static constexpr std::size_t reservable = {};", count);
  if (count == 0) {
    code.line("  static constexpr auto reservations(const LoanSizes&) {{");
    code.line("    return std::array<sft::Reservation, 0>{{}};");
    code.line("  }}");
    return;
  }
  code.line("  static constexpr auto reservations(const LoanSizes& sizes) {{");
  code.line("    return std::array{{");
  for (std::size_t i = 0; i < message.fields.size(); ++i) {
    const Field& field = message.fields[i];
    if (is_reservable(field))
      code.line("        sft::reservation<{}, {}>(sizes.{}),", message.qualified, i, field.name);
  }
  code.line("    }};");
  code.line("  }}");
}

void emit_spans(Code& code, const Message& message) {
  code.line("  explicit LoanView(Loaned_ from) : at_(from) {{}}");
  for (std::size_t i = 0; i < message.fields.size(); ++i) {
    const Field& field = message.fields[i];
    if (!is_reservable(field)) continue;
    code.line("  auto {}() const {{ return at_.template span<{}, {}>(); }}", field.name, i,
              element_type(field.idl->type));
  }
}

}  // namespace

void emit_view(Code& code, const Message& message) {
  code.line("template <class Place_>");
  code.line("class {}::View {{", message.class_head());
  code.line("  Place_ at_;");
  code.blank();
  code.line(" public:");
  code.line("  explicit View(Place_ place) : at_(place) {{}}");
  for (std::size_t i = 0; i < message.fields.size(); ++i) emit_getter(code, message.fields[i], i);
  code.line("}};");
  code.blank();
}

void emit_loan_view(Code& code, const Message& message) {
  const bool has_spans = std::ranges::any_of(message.fields, is_reservable);
  code.line("template <class Loaned_>");
  code.line("class {}::LoanView {{", message.class_head());
  if (has_spans) code.line("  Loaned_ at_;");
  if (has_spans) code.blank();
  code.line(" public:");
  emit_reservations(code, message);
  if (has_spans) emit_spans(code, message);
  if (!has_spans) code.line("  explicit LoanView(Loaned_) {{}}");
  code.line("}};");
  code.blank();
}

}  // namespace sft::idl
