#include "views.h"

#include <algorithm>
#include <string>

#include "spelling.h"

namespace sft::idl {
namespace {

/// Writes a getter for a field that the subscriber did not declare. A call of it does not compile. The
/// compiler's message shows the return type of the getter, whose name says what to do.
void emit_absent(Code& code, const Field& field, std::size_t index) {
  code.line("  sft::detail::this_field_is_not_declared::name_it_where_the_subscriber_is_opened {}() const",
            field.name);
  code.line("      requires(!sft::detail::field_is_in_declared_mask<Place_, {}>) = delete;", index);
}

void emit_getter(Code& code, const Field& field, std::size_t index) {
  const sft_type& type = field.idl->type;
  code.line(
      "  SFT_OUTLIVES_VIEW auto {}() const requires sft::detail::field_is_in_declared_mask<Place_, {}> {{",
      field.name, index);
  code.line("    return at_.template get<{}{}>();", index,
            type.name == nullptr ? "" : ", " + element_type(type));
  code.line("  }}");
  emit_absent(code, field, index);
}

/// Writes the getter of a sequence of numbers that takes the type of a cell as its template argument.
void emit_cells(Code& code, const Field& field, std::size_t index) {
  code.line("  template <class Cell_>");
  code.line(
      "  SFT_OUTLIVES_VIEW auto {}() const requires sft::detail::field_is_in_declared_mask<Place_, {}> {{",
      field.name, index);
  code.line("    return sft::detail::cells_at<Cell_, {}>(at_);", index);
  code.line("  }}");
  code.line("  template <class Cell_>");
  emit_absent(code, field, index);
}

/// Writes points() of a cloud, which returns its points as typed columns.
void emit_points(Code& code) {
  code.line("  template <class... Ts_, class... Names_>");
  code.line("  SFT_OUTLIVES_VIEW auto points(const Names_&... names) const {{");
  code.line("    return sft::detail::points_at<Ts_...>(at_, names...);");
  code.line("  }}");
}

/// Writes to_owned(). For views that cannot lack a field, also writes a conversion to the struct.
void emit_copies(Code& code, const Message& message) {
  code.line("  auto to_owned() const requires sft::detail::has_whole_struct<Place_> {{");
  code.line("    return sft::detail::owned_at<{}>(at_);", message.qualified);
  code.line("  }}");
  code.line(
      "  operator {}() const requires sft::detail::has_declared_struct<Place_> {{ return to_owned(); }}",
      message.qualified);
}

void emit_reservations(Code& code, const Message& message) {
  std::string parts;
  for (std::size_t i = 0; i < message.fields.size(); ++i) {
    const Field& field = message.fields[i];
    if (!has_loan_size(field)) continue;
    const std::string inner = is_reservable(field) ? "" : ", " + element_type(field.idl->type);
    parts += fmt::format("{}\n        sft::detail::reservations_of<{}, {}{}>(sizes.{})",
                         parts.empty() ? "" : ",", message.qualified, i, inner, field.name);
  }
  code.line("  static constexpr auto reservations([[maybe_unused]] const LoanSizes& sizes) {{");
  code.line("    return sft::detail::joined({});", parts);
  code.line("  }}");
}

void emit_loaned(Code& code, const Field& field, std::size_t index) {
  code.line("  SFT_OUTLIVES_VIEW auto {}() const {{ return at_.template {}<{}, {}>(); }}", field.name,
            is_reservable(field) ? "span" : "member", index, element_type(field.idl->type));
}

}  // namespace

void emit_view(Code& code, const Message& message) {
  code.line("template <class Place_>");
  code.line("class {}::View {{", message.class_head());
  code.line("  Place_ at_;");
  code.blank();
  code.line(" public:");
  code.line("  explicit View(Place_ place) : at_(place) {{}}");
  for (std::size_t i = 0; i < message.fields.size(); ++i) {
    emit_getter(code, message.fields[i], i);
    if (is_reservable(message.fields[i])) emit_cells(code, message.fields[i], i);
  }
  if (is_cloud(message)) emit_points(code);
  emit_copies(code, message);
  code.line("}};");
  code.blank();
}

void emit_loan_view(Code& code, const Message& message) {
  const bool is_empty = std::ranges::none_of(message.fields, has_loan_size);
  code.line("template <class Loaned_>");
  code.line("class {}::LoanView {{", message.class_head());
  if (!is_empty) code.line("  Loaned_ at_;");
  if (!is_empty) code.blank();
  code.line(" public:");
  emit_reservations(code, message);
  code.line("  explicit LoanView({}) {}{{}}", is_empty ? "Loaned_" : "Loaned_ from",
            is_empty ? "" : ": at_(from) ");
  for (std::size_t i = 0; i < message.fields.size(); ++i) {
    if (has_loan_size(message.fields[i])) emit_loaned(code, message.fields[i], i);
  }
  code.line("}};");
  code.blank();
}

}  // namespace sft::idl
