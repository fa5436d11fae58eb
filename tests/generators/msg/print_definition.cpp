#include "tests/generators/msg/print_definition.h"

#include <fmt/format.h>

#include "from_msg/type.h"

namespace sft::msg::test {
namespace {

std::string print(const Type& type) {
  std::string text = type.kind == SFT_STRUCTURE ? type.nested.text() : std::string(spelling_of(type.kind));
  if (type.string_bound != 0) text += fmt::format("<={}", type.string_bound);
  if (type.array_size != 0) text += fmt::format("[{}]", type.array_size);
  if (type.is_sequence) text += type.bound == 0 ? "[]" : fmt::format("[<={}]", type.bound);
  return text;
}

std::string in_quotes(std::string_view text) {
  std::string result = "\"";
  for (const char c : text) {
    const bool is_special = static_cast<unsigned char>(c) < 0x20 || c == 0x7F || c == '#';
    if (c == '"' || c == '\\') result += '\\';
    result += is_special ? fmt::format("\\x{:02x}", c) : std::string(1, c);
  }
  return result + '"';
}

std::string print(const Value& value) {
  if (const auto* boolean = std::get_if<bool>(&value)) return *boolean ? "true" : "false";
  if (const auto* text = std::get_if<std::string>(&value)) return in_quotes(*text);
  if (const auto* integer = std::get_if<std::int64_t>(&value)) return fmt::to_string(*integer);
  if (const auto* natural = std::get_if<std::uint64_t>(&value)) return fmt::to_string(*natural);
  return fmt::to_string(std::get<double>(value));
}

std::string print_initial(const Field& field) {
  if (field.initial.empty()) return "";
  if (field.type.is_single()) return " " + print(field.initial.front());
  std::string list;
  for (const Value& value : field.initial) list += (list.empty() ? "" : ", ") + print(value);
  return " [" + list + "]";
}

}  // namespace

std::string print(const Definition& definition) {
  std::string text;
  for (const Constant& c : definition.constants)
    text += fmt::format("{} {}={}\n", print(c.type), c.name, print(c.value));
  for (const Field& f : definition.fields) {
    const std::string unit = f.unit.empty() ? "" : fmt::format("  # [{}]", f.unit);
    const std::string layout = f.layout.text.empty() ? "" : fmt::format("  # @sft_layout {}", f.layout.text);
    text += fmt::format("{} {}{}{}{}\n", print(f.type), f.name, print_initial(f), unit, layout);
  }
  return text;
}

}  // namespace sft::msg::test
