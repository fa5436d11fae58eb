// The five subscribers of the example: the purpose of each, the fields that it declares, and the code that
// reads them. With --arr nothing is declared, and the fields that the same code reads are recorded.
#pragma once

#include <sensor_msgs/msg/PointCloud2.hpp>

#include "sft/points.h"
#include "sft/sample.h"

namespace sft::demo {

using sensor_msgs::msg::PointCloud2;
using Field = PointCloud2::Field;

/// Keeps the compiler from leaving out the reading of a value that nothing is done with.
void use(const auto& value) { asm volatile("" : : "r"(&value) : "memory"); }

/// A recorded sample may lack a channel that is asked for from now on; then there are no points.
void use_points(const auto& points) {
  float sum = 0;
  if (points) {
    for (const auto& point : *points) std::apply([&sum](auto... values) { sum += (values + ...); }, point);
  }
  use(sum);
}

void use_stamp(const auto& cloud) {
  use(cloud.header().stamp().sec());
  use(cloud.header().stamp().nanosec());
}

struct Health {
  static constexpr const char* name = "health";
  static constexpr const char* purpose = "watches that the lidar is alive and sees something";
  static constexpr double max_rate_hz = 0;  // all clouds
  static constexpr Mask<PointCloud2> fields = Field::header | Field::width;
  static void read(const auto& cloud) {
    use_stamp(cloud);
    use(cloud.header().frame_id());
    use(cloud.width());
  }
};

struct Dashboard {
  static constexpr const char* name = "dashboard";
  static constexpr const char* purpose = "shows the operator how large the clouds are";
  static constexpr double max_rate_hz = 0;
  static constexpr Mask<PointCloud2> fields = Field::height | Field::width | Field::is_dense;
  static void read(const auto& cloud) {
    use(cloud.height());
    use(cloud.width());
    use(cloud.is_dense());
  }
};

struct Recorder {
  static constexpr const char* name = "recorder";
  static constexpr const char* purpose = "writes down when each cloud was taken";
  static constexpr double max_rate_hz = 0;
  static constexpr Mask<PointCloud2> fields = Field::header.stamp;
  static void read(const auto& cloud) { use_stamp(cloud); }
};

/// Corrects its odometry now and then: it needs few clouds, and every second column of them.
struct Localiser {
  static constexpr const char* name = "localiser";
  static constexpr const char* purpose = "finds the robot on a map, by one cloud a second";
  static constexpr double max_rate_hz = 1;
  static constexpr Req<PointCloud2> fields =
      Field::header | Field::data.channels<"x", "y", "z", "intensity">.every(2);
  static void read(const auto& cloud) {
    use_stamp(cloud);
    use(cloud.header().frame_id());
    use_points(cloud.template points<float, float, float, float>("x", "y", "z", "intensity"));
  }
};

/// Needs x, y and z of every point. It runs on the lidar's own host, where it reads them in place.
struct Detector {
  static constexpr const char* name = "detector";
  static constexpr const char* purpose = "finds objects, in the lidar's own memory";
  static constexpr double max_rate_hz = 0;
  static constexpr Req<PointCloud2> fields = Field::data.channels<"x", "y", "z">;
  static void read(const auto& cloud) {
    use_points(cloud.template points<float, float, float>("x", "y", "z"));
  }
};

}  // namespace sft::demo
