// Clouds with random values, and samples whose bytes fill their memory exactly, like samples that have
// arrived.
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <cstdint>
#include <cstring>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <string>
#include <utility>
#include <vector>

#include "sft/detail/view.h"
#include "tests/support/cut.h"
#include "tests/support/encoded.h"
#include "tests/support/test_seed.h"

namespace sft::test {

/// Returns a cloud with points of 48 bytes, and 20 bytes of padding after each row. The values of channel
/// "far" reach beyond the end of the point, channel "odd" has an unknown type, and channel "none" has no
/// elements.
inline sensor_msgs::msg::PointCloud2 random_cloud(Random& random, std::uint32_t height, std::uint32_t width) {
  sensor_msgs::msg::PointCloud2 cloud;
  cloud.header.frame_id = "lidar";
  cloud.height = height;
  cloud.width = width;
  cloud.fields = {{"x", 0, 7, 1},          {"y", 4, 7, 1},         {"z", 8, 7, 1},
                  {"intensity", 13, 7, 1}, {"time", 17, 8, 1},     {"reflectivity", 25, 2, 1},
                  {"ring", 27, 4, 1},      {"temperature", 29, 1}, {"tag", 30, 6, 1},
                  {"drift", 34, 3, 1},     {"phase", 36, 5, 3},    {"far", 46, 6, 1},
                  {"odd", 0, 9, 1},        {"none", 0, 7, 0},      {"x", 20, 4, 1}};
  cloud.fields[7].count = 1;
  cloud.point_step = 48;
  cloud.row_step = 48 * width + 20;
  cloud.data.resize(std::size_t{height} * cloud.row_step);
  for (std::uint8_t& byte : cloud.data) byte = static_cast<std::uint8_t>(random());
  return cloud;
}

/// Returns the value at that offset of the data, in bytes.
template <class T>
T value_at(const sensor_msgs::msg::PointCloud2& cloud, std::size_t offset) {
  T value;
  std::memcpy(&value, cloud.data.data() + offset, sizeof value);
  return value;
}

/// Returns the text of the error, or "no error".
std::string message_of(const auto& result) { return result ? "no error" : result.error().message; }

/// A sample of message type T. Its index is built as for a sample that arrived by UDP.
template <class T>
class Arrived {
 public:
  Arrived(std::vector<std::byte> body, FieldMask mask)
      : body_(std::move(body)), mask_(std::move(mask)), index_(detail::slot_count(type)) {
    state_ = {.body = body_.data(),
              .body_bytes = static_cast<std::uint32_t>(body_.size()),
              .index = index_.data(),
              .mask = &mask_};
    is_good_ = detail::build_index(state_, type, index_) == detail::WalkStatus::ok;
  }
  explicit Arrived(const T& value) : Arrived(Encoded(value).bytes(), FieldMask(all<T>)) {}
  /// Makes a sample of the part of a message that a selection names.
  Arrived(const T& value, const char* selection) : Arrived(cut(value, selection)) {}
  Arrived(const Arrived&) = delete;
  Arrived& operator=(const Arrived&) = delete;

  const detail::SampleState& state() const { return state_; }
  bool is_good() const { return is_good_; }
  std::vector<std::byte>& body() { return body_; }
  std::vector<std::uint32_t>& index() { return index_; }
  auto view() const { return detail::view_of<T, all<T>>(state_); }
  DynamicView dynamic_view() const { return {state_, type}; }

 private:
  static constexpr const StructType& type = detail::TypeTable<T>::type;

  explicit Arrived(const Cut<T>& part) : Arrived(part.bytes(), part.mask()) {}
  static Cut<T> cut(const T& value, const char* selection) {
    return {value, type_support<T>().parse_selection(selection).value()};
  }

  std::vector<std::byte> body_;
  FieldMask mask_;
  std::vector<std::uint32_t> index_;
  detail::SampleState state_;
  bool is_good_ = false;
};

}  // namespace sft::test
