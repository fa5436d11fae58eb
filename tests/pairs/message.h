// The peers of these tests publish this message. Every leaf of it tells the message's number.
#pragma once

#include <cstddef>
#include <cstdint>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <span>

#include "sft/mask.h"

namespace sft::test {

using sensor_msgs::msg::PointCloud2;

/// Some kilobytes: several datagrams, unless a mask leaves the data out.
PointCloud2 message(std::uint64_t number);

/// Returns true if these bytes are the encapsulation and the CDR of that message under that mask.
bool is_message(std::uint64_t number, const FieldMask& mask, std::span<const std::byte> cdr);

}  // namespace sft::test
