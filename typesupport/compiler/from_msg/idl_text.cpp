#include "from_msg/idl_text.h"

#include <fmt/format.h>

#include <iterator>
#include <limits>

#include "from_msg/nested.h"

namespace sft::msg {
namespace {

// A leading underscore escapes a name in IDL: the name may then be a keyword, and IDL removes the underscore.
std::string idl_name(const TypeName& type) { return fmt::format("_{}::_msg::_{}", type.package, type.name); }

std::string_view primitive(sft_kind kind) {
  switch (kind) {
    case SFT_BOOLEAN:
      return "boolean";
    case SFT_OCTET:
      return "octet";
    case SFT_INT8:
      return "int8";
    case SFT_UINT8:
      return "uint8";
    case SFT_INT16:
      return "int16";
    case SFT_UINT16:
      return "uint16";
    case SFT_INT32:
      return "int32";
    case SFT_UINT32:
      return "uint32";
    case SFT_INT64:
      return "int64";
    case SFT_UINT64:
      return "uint64";
    case SFT_FLOAT32:
      return "float";
    case SFT_FLOAT64:
      return "double";
    default:
      return "string";
  }
}

std::string element(const Type& type) {
  if (type.kind == SFT_STRUCTURE) return idl_name(type.nested);
  if (type.string_bound != 0) return fmt::format("string<{}>", type.string_bound);
  return std::string(primitive(type.kind));
}

std::string member(const Field& field) {
  const Type& type = field.type;
  if (type.array_size != 0) return fmt::format("{} _{}[{}];", element(type), field.name, type.array_size);
  if (!type.is_sequence) return fmt::format("{} _{};", element(type), field.name);
  // The space separates two closing brackets, which IDL would read as the operator >>.
  const std::string bound = type.bound == 0 ? "" : fmt::format(", {}", type.bound);
  return fmt::format("sequence<{}{} > _{};", element(type), bound, field.name);
}

std::string string_literal(std::string_view text) {
  std::string result = "\"";
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      result += {'\\', c};
    } else {
      result += code < 0x20 || code == 0x7F ? fmt::format("\\{:03o}", code) : std::string(1, c);
    }
  }
  return result + '"';
}

struct ValueText {
  std::string operator()(bool value) const { return value ? "TRUE" : "FALSE"; }
  std::string operator()(std::int64_t value) const {
    // The least value has no literal of its own.
    const bool is_least = value == std::numeric_limits<std::int64_t>::min();
    return is_least ? fmt::format("{} - 1", value + 1) : fmt::to_string(value);
  }
  std::string operator()(std::uint64_t value) const { return fmt::to_string(value); }
  std::string operator()(double value) const {
    const std::string digits = fmt::to_string(value);
    return digits.find_first_of(".e") == digits.npos ? digits + ".0" : digits;
  }
  std::string operator()(const std::string& value) const { return string_literal(value); }
};

}  // namespace

std::string idl_text(const Definition& definition) {
  const TypeName& type = definition.type;
  std::string text;
  const auto line = [&]<class... Args>(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(text), format, std::forward<Args>(args)...);
    text += '\n';
  };
  line("// Generated from {}.msg, for IDL files that include it. Do not edit.", type.text());
  line("#ifndef SFT_MSG_{0}__{1}\n#define SFT_MSG_{0}__{1}", type.package, type.name);
  for (const TypeName& nested : nested_types(definition)) line("#include \"{}.idl\"", nested.text());
  line("module _{} {{\nmodule _msg {{", type.package);
  if (!definition.constants.empty()) line("module {}_Constants {{", type.name);
  for (const Constant& constant : definition.constants) {
    line("  const {} _{} = {};", element(constant.type), constant.name,
         std::visit(ValueText{}, constant.value));
  }
  if (!definition.constants.empty()) line("}};");
  line("@final struct _{} {{", type.name);
  for (const Field& field : definition.fields) line("  {}", member(field));
  line("}};\n}};\n}};\n#endif");
  return text;
}

}  // namespace sft::msg
