// What the peers of these tests publish: a message of which every leaf tells its number.
#pragma once

#include <cstddef>
#include <cstdint>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <span>

#include "sft/typesupport/field_mask.h"

namespace sft::test {

using sensor_msgs::msg::PointCloud2;

/// Some kilobytes: several datagrams, unless a mask leaves the data out.
PointCloud2 message(std::uint64_t number);

/// Whether these are, byte for byte, the encapsulation and the CDR of that message under that mask.
bool is_message(std::uint64_t number, const FieldMask& mask, std::span<const std::byte> cdr);

}  // namespace sft::test
