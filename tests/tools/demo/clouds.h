// Small clouds that tests make, and files of clouds.
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <initializer_list>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sft/detail/decode.h"
#include "tests/support/encoded.h"
#include "tests/support/temporary_directory.h"
#include "tools/demo/clouds/input_cloud.h"

namespace sft::demo {

using Bytes = std::vector<std::byte>;

inline Bytes bytes_of(std::string_view text) {
  const auto* begin = reinterpret_cast<const std::byte*>(text.data());
  return {begin, begin + text.size()};
}

template <class T>
void append(Bytes& bytes, const T& value) {
  const auto* begin = reinterpret_cast<const std::byte*>(&value);
  bytes.insert(bytes.end(), begin, begin + sizeof value);
}

inline void append(Bytes& bytes, const Bytes& more) { bytes.insert(bytes.end(), more.begin(), more.end()); }

/// Returns a cloud with one row of `points` points, 4 bytes each.
inline PointCloud2 small_cloud(std::uint32_t points = 3) {
  PointCloud2 cloud;
  cloud.header.stamp.sec = 7;
  cloud.header.frame_id = "lidar";
  cloud.height = 1;
  cloud.width = points;
  cloud.fields = {point_field("x", 0, sensor_msgs::msg::PointField::FLOAT32)};
  cloud.point_step = 4;
  cloud.row_step = 4 * points;
  cloud.data.resize(cloud.row_step, 0x2a);
  return cloud;
}

/// Returns the encapsulation and the body of a message, in the form that DDS would send.
template <class T>
Bytes payload_of(const T& message) {
  Bytes payload;
  append(payload, sft::detail::encapsulation_cdr_le);
  append(payload, test::Encoded(message).bytes());
  return payload;
}

/// Returns the cloud of the input as a struct.
inline PointCloud2 message_in(const InputCloud& cloud) {
  const std::span<const std::byte> body = std::span(cloud.payload).subspan(sft::detail::encapsulation_bytes);
  const FieldMask mask = cloud_type().full();
  std::vector<std::uint32_t> index(cloud_type().index_slots());
  const sft::detail::SampleState state{.body = body.data(),
                                       .body_bytes = static_cast<std::uint32_t>(body.size()),
                                       .index = index.data(),
                                       .mask = &mask};
  PointCloud2 message;
  EXPECT_EQ(sft::detail::build_index(state, cloud_type().type(), index), sft::detail::WalkStatus::ok);
  EXPECT_EQ(decode(state, cloud_type().type(), &message), sft::detail::WalkStatus::ok);
  return message;
}

inline Bytes record_of(const Bytes& payload) {
  Bytes record;
  append(record, std::uint64_t{1'700'000'000'000'000'000});
  append(record, static_cast<std::uint32_t>(payload.size()));
  append(record, payload);
  return record;
}

using test::TemporaryDirectory;

}  // namespace sft::demo
