// How IDL names are spelled in C++. A name that C++ or the generated code needs for itself gets a trailing
// underscore; type tables keep the IDL name.
#pragma once

#include <string>
#include <string_view>
#include <vector>

namespace sft::idl {

/// Of an enumerator or a constant in a namespace: no keyword, and no macro of the standard headers.
std::string identifier(std::string_view name);

/// The last name of "::pkg::msg::X": "X".
std::string_view last_name(std::string_view scoped);

/// Of a type: besides, none of the names that every generated struct has inside.
std::string type_name(std::string_view scoped);

/// The namespace of "::pkg::msg::X": "pkg::msg", empty at global scope.
std::string namespace_of(std::string_view scoped);

/// "::pkg::msg::X", from the global namespace, so that it means the same inside every scope.
std::string qualified_type(std::string_view scoped);

/// Members and constants of the struct `type_name` (as in C++), in the order of `names`: besides, not the
/// struct's own name, and all different.
std::vector<std::string> member_names(std::string_view type_name, const std::vector<std::string_view>& names);

}  // namespace sft::idl
