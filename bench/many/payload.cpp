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

struct CycloneBulk {
  explicit CycloneBulk(std::size_t data_bytes) : data(data_bytes, 1) {
    const auto length = static_cast<std::uint32_t>(data_bytes);
    message.data = {length, length, data.data(), false};
  }

  std::vector<std::uint8_t> data;
  sft_bench_Bulk message{};
};

}  // namespace

Payload cloud_payload(std::size_t data_bytes) {
  return {.sft =
              [=](Node& node, const std::string& topic, const PublisherOptions& options) {
                return sender_of(cloud(data_bytes), node, topic, options);
              },
          .cyclone_type = &sensor_msgs_msg_PointCloud2_desc,
          .cyclone = [=]() -> std::shared_ptr<void> {
            const auto cloud = std::make_shared<CyclonePointCloud>(data_bytes);
            return {cloud, &cloud->message()};
          }};
}

Payload bulk_payload(std::size_t bytes) {
  const std::size_t data_bytes = bytes - bulk_header_bytes;
  return {.sft =
              [=](Node& node, const std::string& topic, const PublisherOptions& options) {
                return sender_of(bulk(data_bytes), node, topic, options);
              },
          .cyclone_type = &sft_bench_Bulk_desc,
          .cyclone = [=]() -> std::shared_ptr<void> {
            const auto bulk = std::make_shared<CycloneBulk>(data_bytes);
            return {bulk, &bulk->message};
          },
          .reliable = true,
          .sample_bytes_max = std::max(bytes, PublisherOptions{}.max_sample_bytes)};
}

}  // namespace sft::bench
