// Encodes structs of ROS 2 without SFT. Fast CDR writes and reads the members that
// rosidl_typesupport_introspection_cpp lists, in the same way as rmw_fastrtps_dynamic_cpp does.
#pragma once

#include <cstddef>
#include <rosidl_typesupport_introspection_cpp/message_introspection.hpp>
#include <span>
#include <vector>

namespace sft::test {

using RosMembers = rosidl_typesupport_introspection_cpp::MessageMembers;

/// Returns the CDR of a struct, without encapsulation. Padding is zero. Throws if the CDR has more than
/// `bytes_max` bytes.
std::vector<std::byte> serialized_by_ros(const RosMembers& type, const void* message, std::size_t bytes_max);
/// Reads the CDR of a message into a struct.
void deserialize_by_ros(const RosMembers& type, std::span<const std::byte> body, void* message);

}  // namespace sft::test
