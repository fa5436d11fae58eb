// The type support of the message of cloud.h for Fast DDS.
#pragma once

#include "bench/common/cloud.h"
#include "bench/common/fast_cdr.h"
#include "bench/common/fast_dds.h"

namespace sft::bench::fast {

class PointCloudType : public Type<sensor_msgs::msg::PointCloud2> {
 public:
  using Message = sensor_msgs::msg::PointCloud2;

  /// Types of two topics of one participant have different names. The memory grows once to the size of a
  /// message.
  explicit PointCloudType(const char* name = "sensor_msgs::msg::dds_::PointCloud2_") : Type(name, 1024) {}

 protected:
  void encode(const void* data, rtps::SerializedPayload_t& payload) override {
    FastCdrWriter writer(body(payload, payload.max_size));
    // The list of members is for both directions.
    members(writer, *const_cast<Message*>(static_cast<const Message*>(data)));
    encapsulate(payload, writer.bytes());
  }
  bool decode(rtps::SerializedPayload_t& payload, void* data) override {
    FastCdrReader reader(body(payload, payload.length));
    members(reader, *static_cast<Message*>(data));
    return true;
  }
  std::uint32_t encoded_bytes(const void* data) override {
    constexpr std::size_t small_members_max = 1024;
    return static_cast<std::uint32_t>(static_cast<const Message*>(data)->data.size() + small_members_max);
  }
};

}  // namespace sft::bench::fast
