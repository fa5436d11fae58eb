// Types as .msg text, as bags (MCAP's "ros2msg") and ROS 2's tools have it: the definition of the message,
// and behind it those of all messages that it nests, each after a line of '=' and one that names it:
//
//   std_msgs/Header header
//   float64 speed  # [m/s]
//   ================================================================================
//   MSG: std_msgs/Header
//   builtin_interfaces/Time stamp
//   string frame_id
//   ================================================================================
//   MSG: builtin_interfaces/Time
//   ...
//
// The syntax is that of .msg files, and so is the parser (typesupport/compiler/msg.md). Constants, defaults
// and comments but for units are no part of a type: they are read over, and not written.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "sft/dynamic_type.h"
#include "sft/result.h"

namespace sft {

/// The text of which from_msg() makes the same type. An error that names the member where .msg has no word
/// for it: enumerations, characters, keys, and names that ROS 2 does not allow. IDL has them.
Result<std::string> to_msg(const DynamicType& type);

/// The type `name`, "sensor_msgs/PointCloud2", "sensor_msgs/msg/PointCloud2" or
/// "sensor_msgs::msg::PointCloud2", as `text` defines it. The text may be hostile. An error names the
/// message, the line within its definition and the field, and says what to do.
Result<DynamicType> from_msg(std::string_view name, std::string_view text,
                             const DescriptionLimits& limits = {});

/// The type `name` as the first of `roots` defines it, directories of packages, as /opt/ros/humble/share is
/// one: in ROOT/sensor_msgs/msg/PointCloud2.msg. What it nests is looked for likewise. Errc::unavailable if
/// no root has the message.
Result<DynamicType> find_msg(std::string_view name, std::span<const std::filesystem::path> roots,
                             const DescriptionLimits& limits = {});

/// The type of a file, ROOT/my_msgs/msg/Status.msg. What it nests is looked for below its own ROOT, and then
/// below `roots`.
Result<DynamicType> from_msg_file(const std::filesystem::path& file,
                                  std::span<const std::filesystem::path> roots = {},
                                  const DescriptionLimits& limits = {});

}  // namespace sft
