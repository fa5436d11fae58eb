// A generated yard as a spinning lidar sees it: the ground, and a moving wall around it. The same time
// always gives the same bytes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <span>

#include "sft/publisher.h"

namespace sft::demo {

using sensor_msgs::msg::PointCloud2;

/// A point in the layout of Ouster's ROS driver.
struct LidarPoint {
  float x = 0;  ///< x, y and z are in metres, and 0 if nothing was hit
  float y = 0;
  float z = 0;
  float unused_w = 0;
  float intensity = 0;
  std::uint32_t t = 0;  ///< nanoseconds since the scan began
  std::uint16_t reflectivity = 0;
  std::uint16_t ring = 0;  ///< number of the row
  std::uint16_t ambient = 0;
  std::uint16_t unused_after_ambient = 0;
  std::uint32_t range = 0;  ///< distance in millimetres; 0: nothing was hit
  std::uint32_t unused_at_end[3] = {};
};
static_assert(sizeof(LidarPoint) == 48);

class Scene {
 public:
  static constexpr std::uint32_t rows = 128;  ///< row 0 looks up
  static constexpr std::uint32_t columns = 1024;
  static constexpr std::uint32_t points = rows * columns;
  static constexpr std::size_t bytes = points * sizeof(LidarPoint);

  Scene();

  /// Writes the scan at that time into `cloud`, row by row. REQUIRES: cloud.size() == bytes.
  static void render(double seconds, std::span<std::uint8_t> cloud);
  /// Publishes the scan at that time.
  Result<PublishStatus> publish(Publisher<PointCloud2>& publisher, double seconds) const;
  /// Returns the bytes of the encapsulation and the body of a whole message.
  std::uint64_t full_bytes() const;

 private:
  PointCloud2 layout_;  // the message without the points
};

}  // namespace sft::demo
