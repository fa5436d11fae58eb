// Parses the types of .msg files: "float32", "string<=8[<=4]", "Point[]", "geometry_msgs/Point".
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "from_msg/definition.h"

namespace sft::msg {

/// Parses a type. A name without a package is a type of `package`. The error says what is wrong and what was
/// expected.
tl::expected<Type, std::string> parse_type(std::string_view text, std::string_view package);

/// Returns the name of a kind, "bool" to "string". The name of SFT_UINT8 is "uint8", not "char".
std::string_view spelling_of(sft_kind kind);

}  // namespace sft::msg
