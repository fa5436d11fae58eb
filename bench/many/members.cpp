#include "bench/many/members.h"

#include <sensor_msgs/msg/PointCloud2.h>

#include "bench/common/cloud.h"

namespace sft::bench {

Topic cloud_topic(std::size_t data_bytes, const std::string& name) {
  return {.name = name,
          .messages = shared(std::vector{cloud(data_bytes)}, sensor_msgs_msg_PointCloud2_desc),
          .reliable = false};
}

}  // namespace sft::bench
