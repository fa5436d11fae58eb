// The five subscribers of the example: the purpose of each, the fields that it declares, and the code that
// reads them. With --arr nothing is declared, and the fields that the same code reads are recorded.
#pragma once

#include <concepts>
#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

#include <sensor_msgs/msg/PointCloud2.hpp>

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
  /// Reads one byte of every cache line, which moves as much memory as reading all bytes.
  void operator()(std::span<const std::uint8_t> bytes) {
    for (std::size_t i = 0; i < bytes.size(); i += 64) sum_ += bytes[i];
  }
  /// Recorded fields are empty if the sample does not have them.
  template <class T>
  void operator()(const std::optional<T>& value) {
    if (value) (*this)(*value);
  }

 private:
  std::uint64_t sum_ = 0;
};

/// The rate of a subscriber that does not name another one.
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

/// The layout of a point, which a program needs before it can read x, y and z in `data`.
struct Layout {
  static void read(const auto& cloud, Use& use) {
    read_fields(cloud.fields(), use);
    use(cloud.point_step());
  }

 private:
  template <class Range>
  static void read_fields(const Range& fields_of_points, Use& use) {
    for (const auto& field : fields_of_points) {
      use(field.name());
      use(field.offset());
      use(field.datatype());
      use(field.count());
    }
  }
  template <class Range>
  static void read_fields(const Optional<Range>& fields_of_points, Use& use) {
    if (fields_of_points) read_fields(*fields_of_points, use);
  }
};

/// Corrects its odometry now and then: it needs few clouds, but nearly all fields of them.
struct Localiser {
  static constexpr const char* name = "localiser";
  static constexpr const char* purpose = "finds the robot on a map, by one cloud a second";
  static constexpr double max_rate_hz = 1;
  static constexpr Mask<PointCloud2> fields = ~PointCloud2::Field::height;
  static void read(const auto& cloud, Use& use) {
    read_stamp(cloud, use);
    use(cloud.header().frame_id());
    use(cloud.width());
    Layout::read(cloud, use);
    use(cloud.is_bigendian());
    use(cloud.row_step());
    use(cloud.data());
    use(cloud.is_dense());
  }
};

/// Needs x, y and z of every point. It runs on the lidar's own host, where reading them costs nothing.
struct Detector : EveryCloud {
  static constexpr const char* name = "detector";
  static constexpr const char* purpose = "finds objects, in the lidar's own memory";
  static constexpr Mask<PointCloud2> fields =
      PointCloud2::Field::fields | PointCloud2::Field::point_step | PointCloud2::Field::data;
  static void read(const auto& cloud, Use& use) {
    Layout::read(cloud, use);
    use(cloud.data());
  }
};

}  // namespace sft::demo
