#include "bench/many/payload.h"

#include <algorithm>
#include <cstdint>
#include <messages.hpp>
#include <vector>

#include "bench/common/cyclone_point_cloud.h"
#include "messages.h"

namespace sft::bench {

namespace {

constexpr std::size_t bulk_header_bytes = 20;  // a number, a stamp, and the length of the data

sft_bench::Bulk bulk(std::size_t data_bytes) {
  sft_bench::Bulk bulk;
  bulk.data.resize(data_bytes, 1);
  return bulk;
}

class CycloneBulk {
 public:
  explicit CycloneBulk(std::size_t data_bytes) : data_(data_bytes, 1) {
    const auto length = static_cast<std::uint32_t>(data_bytes);
    message_.data = {length, length, data_.data(), false};
  }
  sft_bench_Bulk& message() { return message_; }

 private:
  std::vector<std::uint8_t> data_;
  sft_bench_Bulk message_{};
};

/// `make(data_bytes)` makes SFT's message, and a `CycloneMessage` holds Cyclone's.
template <class CycloneMessage, class Make>
Payload payload_of(Make make, const dds_topic_descriptor_t& type, std::size_t data_bytes) {
  return {.sft =
              [=](Node& node, const std::string& topic, const PublisherOptions& options) {
                return sender_of(make(data_bytes), node, topic, options);
              },
          .cyclone_type = &type,
          .cyclone = [=]() -> std::shared_ptr<void> {
            const auto held = std::make_shared<CycloneMessage>(data_bytes);
            return {held, &held->message()};
          },
          .sample_bytes = data_bytes};
}

}  // namespace

Payload cloud_payload(std::size_t data_bytes) {
  return payload_of<CyclonePointCloud>(&cloud, sensor_msgs_msg_PointCloud2_desc, data_bytes);
}

Payload bulk_payload(std::size_t bytes) {
  Payload payload = payload_of<CycloneBulk>(&bulk, sft_bench_Bulk_desc, bytes - bulk_header_bytes);
  payload.reliable = true;
  payload.sample_bytes_max = std::max(bytes, PublisherOptions{}.max_sample_bytes);
  return payload;
}

}  // namespace sft::bench
