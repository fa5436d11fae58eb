// Parses the text of a .srv file: two messages with a line "---" between them (msg.md).
#pragma once

#include <string_view>
#include <tl/expected.hpp>
#include <vector>

#include "from_msg/definition.h"

namespace sft::msg {

/// Parses the text. Returns the definitions of the request, the response, and the two messages that carry
/// them: NAME_Request, NAME_Response, NAME_Call and NAME_Reply, in this order. Returns errors in the order
/// of lines if the text has any.
tl::expected<std::vector<Definition>, std::vector<Problem>> parse_service(std::string_view text,
                                                                          const TypeName& name);

}  // namespace sft::msg
