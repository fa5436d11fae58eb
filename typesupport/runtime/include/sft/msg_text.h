// Types as .msg text, in the form of bags (MCAP's "ros2msg") and of ROS 2's tools. The text has the
// definition of the message, followed by the definitions of all messages that it nests. Before each of these
// is a line of '=' and a line with its name:
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
// Syntax and parser are those of .msg files (typesupport/compiler/msg.md). Constants, defaults, and comments
// other than units and layout rules (@sft_layout) are not a part of a type. They are skipped when a text is
// read, and they are not written.
//
// All functions are pure, except that two of them read files; any thread may call them. They allocate memory.
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>

#include "sft/dynamic_type.h"
#include "sft/result.h"

namespace sft {

/// Writes the text from which from_msg() makes the same type. Returns an error that names the member if
/// .msg cannot express it: enumerations, characters, keys, and names that ROS 2 does not allow. IDL can
/// express all of these.
Result<std::string> to_msg(const DynamicType& type);

/// Makes the type `name` ("sensor_msgs/PointCloud2", "sensor_msgs/msg/PointCloud2" or
/// "sensor_msgs::msg::PointCloud2") from its definition in `text`. The text may be hostile. An error names
/// the message, the line within its definition and the field, and says what to do.
Result<DynamicType> from_msg(std::string_view name, std::string_view text,
                             const DynamicType::Limits& limits = {});

/// Makes the type `name` from the first of `roots` that has a file for the type. A root is a directory of
/// packages, such as /opt/ros/humble/share; the file is ROOT/sensor_msgs/msg/PointCloud2.msg. Nested
/// messages are searched for in the same way. The messages of a service are found, too:
/// "std_srvs/srv/SetBool_Call", or _Reply, _Request or _Response, in ROOT/std_srvs/srv/SetBool.srv. The error
/// is Errc::unavailable if no root has the message.
Result<DynamicType> find_msg(std::string_view name, std::span<const std::filesystem::path> roots,
                             const DynamicType::Limits& limits = {});

/// Makes the type of a file, ROOT/my_msgs/msg/Status.msg. Nested messages are searched for below this ROOT,
/// and then below `roots`.
Result<DynamicType> from_msg_file(const std::filesystem::path& file,
                                  std::span<const std::filesystem::path> roots = {},
                                  const DynamicType::Limits& limits = {});

}  // namespace sft
