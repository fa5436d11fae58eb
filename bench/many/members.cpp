#include "bench/many/members.h"

#include <messages.h>
#include <sensor_msgs/msg/PointCloud2.h>

#include <messages.hpp>

#include "bench/common/cloud.h"

namespace sft::bench {

Topic cloud_topic(std::size_t data_bytes, const std::string& name) {
  return {.name = name,
          .messages = shared(std::vector{cloud(data_bytes)}, sensor_msgs_msg_PointCloud2_desc),
          .reliable = false};
}

Topic bulk_topic(std::size_t bytes) {
  constexpr std::size_t header_bytes = 20;  // bytes of a number, a stamp, and the length of the data
  sft_bench::Bulk bulk;
  bulk.data.resize(bytes - header_bytes, 1);
  return {.name = "points", .messages = shared(std::vector{std::move(bulk)}, sft_bench_Bulk_desc)};
}

}  // namespace sft::bench
