// Parses the values of .msg files.
#pragma once

#include <string>
#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "from_msg/definition.h"

namespace sft::msg {

/// Parses the value of a constant, or the default of a field. The result has one value for a single field,
/// and one per element for an array or a sequence, "[1, 2, 3]". The error says what is wrong and what was
/// expected. REQUIRES: `text` has no spaces around it.
tl::expected<std::vector<Value>, std::string> parse_values(const Type& type, std::string_view text);

}  // namespace sft::msg
