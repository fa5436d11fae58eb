#include "naming.h"

#include <algorithm>
#include <array>
#include <span>

#include "macros.h"

namespace sft::idl {
namespace {

constexpr std::array keywords = std::to_array<std::string_view>(
    {"alignas",     "alignof",  "and",        "and_eq",    "asm",       "auto",         "bitand",
     "bitor",       "bool",     "break",      "case",      "catch",     "char",         "char16_t",
     "char32_t",    "char8_t",  "class",      "co_await",  "co_return", "co_yield",     "compl",
     "concept",     "const",    "const_cast", "consteval", "constexpr", "constinit",    "continue",
     "decltype",    "default",  "delete",     "do",        "double",    "dynamic_cast", "else",
     "enum",        "explicit", "export",     "extern",    "false",     "float",        "for",
     "friend",      "goto",     "if",         "inline",    "int",       "long",         "mutable",
     "namespace",   "new",      "noexcept",   "not",       "not_eq",    "nullptr",      "operator",
     "or",          "or_eq",    "private",    "protected", "public",    "register",     "reinterpret_cast",
     "requires",    "return",   "short",      "signed",    "sizeof",    "static",       "static_assert",
     "static_cast", "struct",   "switch",     "template",  "this",      "thread_local", "throw",
     "true",        "try",      "typedef",    "typeid",    "typename",  "union",        "unsigned",
     "using",       "virtual",  "void",       "volatile",  "wchar_t",   "while",        "xor",
     "xor_eq"});

/// The names that every generated struct, its View and its LoanView define in addition to the fields of the
/// message.
constexpr std::array class_names = std::to_array<std::string_view>(
    {"Field", "Fields", "LoanSizes", "LoanView", "View", "reservations", "to_owned"});

/// The template parameters and private members in generated classes (fields.cpp, views.cpp, owned.cpp).
constexpr std::array private_names =
    std::to_array<std::string_view>({"Cell_", "First_", "Loaned_", "Of_", "Place_", "Root_", "at_"});

bool is_one_of(std::span<const std::string_view> names, std::string_view name) {
  return std::find(names.begin(), names.end(), name) != names.end();
}

bool is_taken(std::string_view name) { return is_one_of(keywords, name) || is_macro(name); }

bool is_taken_in_class(std::string_view name) {
  return is_taken(name) || is_one_of(class_names, name) || is_one_of(private_names, name);
}

std::string marked(std::string_view name, bool needs_mark) {
  return std::string(name) + (needs_mark ? "_" : "");
}

/// Returns true for a name that would hide the std:: or sft:: of generated code if it were the name of an
/// inner namespace.
bool hides_a_namespace(std::string_view name) { return name == "std" || name == "sft"; }

std::string module_name(std::string_view name, bool is_outermost) {
  const bool is_ours = is_outermost && name == "sft";
  return marked(name, is_taken(name) || (hides_a_namespace(name) && !is_ours));
}

std::string_view scope_of(std::string_view scoped) { return scoped.substr(0, scoped.rfind("::")); }

}  // namespace

std::string identifier(std::string_view name) { return marked(name, is_taken(name)); }

std::string_view last_name(std::string_view scoped) { return scoped.substr(scoped.rfind("::") + 2); }

std::string type_name(std::string_view scoped) {
  const std::string_view name = last_name(scoped);
  return marked(name, is_taken_in_class(name) || hides_a_namespace(name));
}

std::string namespace_of(std::string_view scoped) {
  std::string result;
  for (std::string_view rest = scope_of(scoped); !rest.empty();) {
    rest.remove_prefix(2);  // removes the "::"
    const std::string_view name = rest.substr(0, rest.find("::"));
    result += (result.empty() ? "" : "::") + module_name(name, result.empty());
    rest.remove_prefix(name.size());
  }
  return result;
}

bool is_plain_namespace(std::string_view name) {
  const auto is_letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; };
  const auto is_digit = [](char c) { return c >= '0' && c <= '9'; };
  return !name.empty() && is_letter(name[0]) && !is_taken(name) && !hides_a_namespace(name) &&
         std::ranges::all_of(name, [&](char c) { return is_letter(c) || is_digit(c); });
}

std::string qualified_type(std::string_view scoped) {
  const std::string scope = namespace_of(scoped);
  return "::" + scope + (scope.empty() ? "" : "::") + type_name(scoped);
}

std::vector<std::string> member_names(std::string_view type_name,
                                      const std::vector<std::string_view>& names) {
  const auto is_free = [&](std::string_view name) { return !is_taken_in_class(name) && name != type_name; };
  std::vector<std::string> result(names.begin(), names.end());
  for (std::string& name : result) {
    // A name that is not free gets underscores until it is free and differs from all other names.
    while (!is_free(name) || std::count(result.begin(), result.end(), name) > 1) name += '_';
  }
  return result;
}

}  // namespace sft::idl
