// The type that the samples of a selection have in a recording, and its definition.
//
// Samples with all fields have the type of the topic, also if they have parts of fields only. Samples without
// some fields have the type of just the fields that they have. That type has a name of its own, such as
// sensor_msgs/msg/PointCloud2Part3f, so that no reader takes it for the whole one (docs/recordings.md).
#pragma once

#include <string>
#include <string_view>

#include "sft/dynamic_type.h"
#include "sft/result.h"
#include "sft/selection.h"

namespace sft::recording {

struct SampleType {
  std::string name;        ///< "sensor_msgs/msg/PointCloud2"
  std::string definition;  ///< as "ros2msg" has it, with all types that it nests
};

/// Returns the type of samples with these fields, which are those that are sent: a closed mask. The error
/// names a field that .msg cannot express.
Result<SampleType> sample_type(const DynamicType& type, const FieldMask& mask);

/// Reads what a user selects: a text as parse_selection() takes it. A text that names nothing but parts of
/// fields selects the rest of the message, too, so that its samples are valid messages of the topic's type;
/// other fields with the same rows and columns get the same part. The result is closed.
Result<Selection> selection_of(const DynamicType& type, std::string_view text);

/// "sensor_msgs/msg/Imu" of "sensor_msgs::msg::Imu".
std::string ros_type_name(std::string_view name);

}  // namespace sft::recording
