// Types as .msg files spell them: "float32", "string<=8[<=4]", "Point[]", "geometry_msgs/Point".
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <tl/expected.hpp>

#include "from_msg/definition.h"

namespace sft::msg {

/// The error says what is wrong and what was expected. A name without package means a type of `package`.
tl::expected<Type, std::string> parse_type(std::string_view text, std::string_view package);

/// "bool" ... "string": how a kind is spelled; of uint8 that, not "char".
std::string_view spelling_of(sft_kind kind);

}  // namespace sft::msg
