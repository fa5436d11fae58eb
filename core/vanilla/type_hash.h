// The hash by which nodes of ROS 2 (Iron and later) compare the definitions of a message type (REP 2016).
// Pure.
#pragma once

#include <optional>
#include <string>

#include "sft/type.h"

namespace sft::core {

/// "RIHS01_" and 64 hexadecimal digits. Nothing if ROS 2 has no such types: enumerations, bitmasks and keys.
/// The hash is that of ROS 2 for types that .msg files define.
std::optional<std::string> ros_type_hash(const StructType& type);

}  // namespace sft::core
