// The type of a selection's samples in a recording, and its definition.
//
// Samples with all fields have the type of the topic, even if they have only parts of some fields. Samples
// without some fields have a type with only the fields that they have. That type has its own name, such as
// sensor_msgs/msg/PointCloud2Part3f, so that readers do not confuse it with the whole type
// (docs/recordings.md).
#pragma once

#include <string>
#include <string_view>

#include "sft/dynamic_type.h"
#include "sft/result.h"
#include "sft/selection.h"

namespace sft::recording {

struct SampleType {
  std::string name;        ///< "sensor_msgs/msg/PointCloud2"
  std::string definition;  ///< the definition in the form "ros2msg", with all nested types
};

/// Returns the type of samples that have the fields of the mask. REQUIRES: the mask is closed. The error
/// names a field that .msg cannot express.
Result<SampleType> sample_type(const DynamicType& type, const FieldMask& mask);

/// Reads the selection of a user, a text in the form of parse_selection(). If the text names only parts of
/// fields, the selection also gets all other fields, so that its samples are valid messages of the topic's
/// type. Other fields with the same rows and columns get the same part. The result is closed.
Result<Selection> selection_of(const DynamicType& type, std::string_view text);

/// Returns "sensor_msgs/msg/Imu" for "sensor_msgs::msg::Imu".
std::string ros_type_name(std::string_view name);

}  // namespace sft::recording
