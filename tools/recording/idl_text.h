// Converts definitions in the form "ros2idl" to the form "ros2msg".
#pragma once

#include <string>
#include <string_view>

#include "sft/result.h"

namespace sft::recording {

/// Returns the definition of `name` ("my_msgs/msg/Status") and of all other types in the text, in the form
/// "ros2msg". Reads the IDL that ROS 2 generates from messages: structs, arrays by typedef, sequences and
/// bounds. Constants and annotations are skipped. The text may be hostile. The error names the first
/// construct that is not supported.
Result<std::string> msg_of_idl(std::string_view name, std::string_view text);

}  // namespace sft::recording
