// The five subscribers of the example: the purpose of each, the fields that it declares, and the code that
// reads them. With --arr nothing is declared, and the fields that the same code reads are recorded.
#pragma once

#include <concepts>
#include <cstdint>
#include <optional>
#include <string_view>
#include <tuple>

#include <sensor_msgs/msg/PointCloud2.hpp>

#include "sft/points.h"
#include "sft/sample.h"

namespace sft::demo {

using sensor_msgs::msg::PointCloud2;

/// Uses all values that are read, so that the compiler cannot remove the reading.
class Use {
 public:
  template <class T>
  requires std::integral<T> || std::floating_point<T>
  void operator()(T value) { sum_ += static_cast<std::uint64_t>(value); }
  void operator()(std::string_view text) { sum_ += text.size(); }
  /// A recorded sample may lack a channel that was not requested before this call.
  template <class... Ts>
  void operator()(const Result<Cells<std::tuple<Ts...>>>& points) {
    if (!points) return;
    float sum = 0;
    for (const auto& point : *points)
      std::apply([&sum](auto... values) { sum += (static_cast<float>(values) + ...); }, point);
    points_ += sum;
  }
  /// Recorded fields are empty if the sample does not have them.
  template <class T>
  void operator()(const std::optional<T>& value) {
    if (value) (*this)(*value);
  }

 private:
  std::uint64_t sum_ = 0;
  float points_ = 0;
};

/// The default rate of a subscriber.
struct EveryCloud {
  static constexpr double max_rate_hz = 0;  ///< all clouds
};

void read_stamp(const auto& cloud, Use& use) {
  use(cloud.header().stamp().sec());
  use(cloud.header().stamp().nanosec());
}

struct Health : EveryCloud {
  static constexpr const char* name = "health";
  static constexpr const char* purpose = "watches that the lidar is alive and sees something";
  static constexpr Mask<PointCloud2> fields = PointCloud2::Field::header | PointCloud2::Field::width;
  static void read(const auto& cloud, Use& use) {
    read_stamp(cloud, use);
    use(cloud.header().frame_id());
    use(cloud.width());
  }
};

struct Dashboard : EveryCloud {
  static constexpr const char* name = "dashboard";
  static constexpr const char* purpose = "shows the operator how large the clouds are";
  static constexpr Mask<PointCloud2> fields =
      PointCloud2::Field::height | PointCloud2::Field::width | PointCloud2::Field::is_dense;
  static void read(const auto& cloud, Use& use) {
    use(cloud.height());
    use(cloud.width());
    use(cloud.is_dense());
  }
};

struct Recorder : EveryCloud {
  static constexpr const char* name = "recorder";
  static constexpr const char* purpose = "writes down when each cloud was taken";
  static constexpr Mask<PointCloud2> fields = PointCloud2::Field::header.stamp;
  static void read(const auto& cloud, Use& use) { read_stamp(cloud, use); }
};

/// Corrects its odometry now and then: it needs few clouds, and every second column of them.
struct Localiser {
  static constexpr const char* name = "localiser";
  static constexpr const char* purpose = "finds the robot on a map, by one cloud a second";
  static constexpr double max_rate_hz = 1;
  static constexpr Req<PointCloud2> fields =
      PointCloud2::Field::header | PointCloud2::Field::data.channels<"x", "y", "z", "intensity">.every(2);
  static void read(const auto& cloud, Use& use) {
    read_stamp(cloud, use);
    use(cloud.header().frame_id());
    use(cloud.template points<float, float, float, float>("x", "y", "z", "intensity"));
  }
};

/// Needs x, y and z of every point. It runs on the lidar's own host, where it reads them in place.
struct Detector : EveryCloud {
  static constexpr const char* name = "detector";
  static constexpr const char* purpose = "finds objects, in the lidar's own memory";
  static constexpr Req<PointCloud2> fields = PointCloud2::Field::data.channels<"x", "y", "z">;
  static void read(const auto& cloud, Use& use) {
    use(cloud.template points<float, float, float>("x", "y", "z"));
  }
};

}  // namespace sft::demo
