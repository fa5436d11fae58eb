// Names of macros that stand in the way of names in generated headers.
#pragma once

#include <string_view>
#include <vector>

namespace sft::idl {

/// True for EOF, EINVAL, INT8_MAX, ...: names that cannot be used in C++, because standard headers define
/// them.
bool is_macro(std::string_view name);

/// Returns the names in this text of C++ that Qt, X11, Windows, or programs by -D are known to define as
/// macros. A header that uses them has to put such macros aside until its end.
std::vector<std::string_view> foreign_macros_in(std::string_view text);

}  // namespace sft::idl
