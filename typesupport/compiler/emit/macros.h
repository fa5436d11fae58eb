// Names of macros that collide with names in generated headers.
#pragma once

#include <string_view>
#include <vector>

namespace sft::idl {

/// Returns true for names that cannot be used in C++, because standard headers define them as macros: EOF,
/// EINVAL, INT8_MAX and others.
bool is_macro(std::string_view name);

/// Returns the names in this C++ text that other software is known to define as macros: Qt, X11, Windows,
/// or a compiler's option -D. A header with these names has to disable the macros until its end.
std::vector<std::string_view> foreign_macros_in(std::string_view text);

}  // namespace sft::idl
