// Definitions in "ros2idl", as those in "ros2msg".
#pragma once

#include <string>
#include <string_view>

#include "sft/result.h"

namespace sft::recording {

/// Returns the definition of `name` ("my_msgs/msg/Status"), and of all that the text defines beside it, as
/// "ros2msg" has them. It reads the IDL that ROS 2 makes of its messages: structs, arrays by typedef,
/// sequences, bounds. Constants and annotations are skipped. The text may be hostile; the error names what
/// the reader does not know.
Result<std::string> msg_of_idl(std::string_view name, std::string_view text);

}  // namespace sft::recording
