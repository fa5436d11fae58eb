// The hash by which nodes of ROS 2 (Iron and later) compare the definitions of a message type (REP 2016). A
// pure function.
#pragma once

#include <optional>
#include <string>

#include "sft/type.h"

namespace sft::core {

/// Returns "RIHS01_" and 64 hexadecimal digits: the hash that ROS 2 computes for a type in a .msg file.
/// Returns nothing if the type has enumerations, bitmasks or keys, which ROS 2 does not have.
std::optional<std::string> ros_type_hash(const StructType& type);

}  // namespace sft::core
