// Names that cannot be used in C++ because standard headers define them as macros.
#pragma once

#include <string_view>

namespace sft::idl {

/// True for EOF, EINVAL, INT8_MAX, ...
bool is_macro(std::string_view name);

}  // namespace sft::idl
