// The spelling of IDL names in C++. A name that has a meaning in C++ or in the generated code gets a
// trailing underscore. Type tables keep the IDL name.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace sft::idl {

/// Returns the C++ name of an enumerator, or of a constant in a namespace. The result avoids keywords, and
/// macros of standard headers.
std::string identifier(std::string_view name);

/// Returns the last name of "::pkg::msg::X", which is "X".
std::string_view last_name(std::string_view scoped);

/// Returns the C++ name of a type. The result also avoids the names that every generated struct defines.
std::string type_name(std::string_view scoped);

/// Returns the namespace of "::pkg::msg::X", which is "pkg::msg"; empty at global scope.
std::string namespace_of(std::string_view scoped);

/// Returns true for an identifier that generated code can use unchanged as a namespace.
bool is_plain_namespace(std::string_view name);

/// Returns the name "::pkg::msg::X". The name begins at the global namespace, and so means the same in
/// every scope.
std::string qualified_type(std::string_view scoped);

/// Returns the C++ names of members and constants of the struct whose C++ name is `type_name`, in the order
/// of `names`. The names differ from each other and from the struct's own name.
std::vector<std::string> member_names(std::string_view type_name, const std::vector<std::string_view>& names);

}  // namespace sft::idl
