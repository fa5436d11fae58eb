// The message that the peers of these tests publish. The value of every leaf depends on the message's number.
#pragma once

#include <cstddef>
#include <cstdint>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <span>

#include "sft/mask.h"

namespace sft::test {

using sensor_msgs::msg::PointCloud2;

/// Returns the message with that number. The message has some kilobytes, which need several datagrams unless
/// a mask omits the data.
PointCloud2 message(std::uint64_t number);

/// Returns true if these bytes are the encapsulation and the CDR of the message with that number, under that
/// mask.
bool is_message(std::uint64_t number, const FieldMask& mask, std::span<const std::byte> cdr);

}  // namespace sft::test
