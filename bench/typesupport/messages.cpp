#include "bench/typesupport/messages.h"

namespace sft::bench {

using namespace detail;
nav_msgs::msg::Odometry odometry() {
  nav_msgs::msg::Odometry odometry{.header = header("odom"), .child_frame_id = "base_link"};
  odometry.pose.pose.position = {.x = 1, .y = 2, .z = 3};
  odometry.twist.twist.linear = {.x = 4, .y = 5, .z = 6};
  for (std::size_t i = 0; i < 36; ++i) odometry.pose.covariance[i] = static_cast<double>(i);
  return odometry;
}

Sample::Sample(const StructType& type, const void* value, const FieldMask& mask)
    : type_(type),
      mask_(mask),
      bytes_(encoded_size(type, value, mask).bytes),
      memory_(bytes_ / 8 + 1),
      index_(slot_count(type)) {
  encode_again(value);
  state_ = {.body = body().data(), .body_bytes = bytes_, .index = index_.data(), .mask = &mask_};
}

void Sample::encode_again(const void* value) {
  const EncodedSize size = encoded_size(type_, value, mask_);
  encode(type_, value, mask_, body().first(size.bytes), index_);
}

}  // namespace sft::bench
