// Publishes scans of the generated yard as point clouds.
#pragma once

#include <cstdint>
#include <sensor_msgs/msg/PointCloud2.hpp>

#include "sft/publisher.h"
#include "tools/demo/clouds/scene.h"

namespace sft::demo {

using sensor_msgs::msg::PointCloud2;

class SceneSource {
 public:
  SceneSource();

  /// Publishes the scan at that time.
  Result<PublishStatus> publish(Publisher<PointCloud2>& publisher, double seconds) const;
  /// Returns the bytes of the encapsulation and the body of a whole message.
  std::uint64_t full_bytes() const;

 private:
  const Scene scene_;
  const PointCloud2 prototype_;  // all but the points
};

}  // namespace sft::demo
