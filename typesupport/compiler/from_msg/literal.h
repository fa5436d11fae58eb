// Values as .msg files write them.
#pragma once

#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "from_msg/definition.h"

namespace sft::msg {

/// The value of a constant, or the default of a field: of a single value one, of an array or a sequence one
/// per element, from "[1, 2, 3]". `text` has no spaces around it. The error says what is wrong and what was
/// expected.
tl::expected<std::vector<Value>, std::string> parse_values(const Type& type, std::string_view text);

}  // namespace sft::msg
