// The four subscribers of the example: what each is for, the fields that it declares, and the code that reads
// them. With
// --arr nothing is declared, and the same code is what the fields are recorded from.
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

/// Takes what is read and makes something of it, so that the compiler cannot leave the reading out.
class Use {
 public:
  template <class T>
  requires std::integral<T> || std::floating_point<T>
  void operator()(T value) { sum_ += static_cast<std::uint64_t>(value); }
  void operator()(std::string_view text) { sum_ += text.size(); }
  /// A byte of every cache line: as far as memory is concerned, all of it.
  void operator()(std::span<const std::uint8_t> bytes) {
    for (std::size_t i = 0; i < bytes.size(); i += 64) sum_ += bytes[i];
  }
  /// Where fields are recorded: empty if the sample does not have it.
  template <class T>
  void operator()(const std::optional<T>& value) {
    if (value) (*this)(*value);
  }

 private:
  std::uint64_t sum_ = 0;
};

/// Watches that the LiDAR works: the shape of its clouds is enough.
struct Diagnostic {
  static constexpr const char* name = "diagnostic";
  static constexpr Mask<PointCloud2> fields = PointCloud2::Field::height | PointCloud2::Field::width;
  static void read(const auto& cloud, Use& use) {
    use(cloud.height());
    use(cloud.width());
  }
};

/// Finds objects in the points.
struct Detector {
  static constexpr const char* name = "detector";
  static constexpr Mask<PointCloud2> fields = PointCloud2::Field::data;
  static void read(const auto& cloud, Use& use) { use(cloud.data()); }
};

/// Maps and localizes; goes through the points without regard to rows.
struct Slam {
  static constexpr const char* name = "slam";
  static constexpr Mask<PointCloud2> fields = ~PointCloud2::Field::height;
  static void read(const auto& cloud, Use& use) {
    use(cloud.header().stamp().sec());
    use(cloud.header().stamp().nanosec());
    use(cloud.header().frame_id());
    use(cloud.width());
    read_fields(cloud.fields(), use);
    use(cloud.is_bigendian());
    use(cloud.point_step());
    use(cloud.row_step());
    use(cloud.data());
    use(cloud.is_dense());
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

/// Draws the cloud on the LiDAR's own host. There, all fields cost nothing.
struct Viewer {
  static constexpr const char* name = "viewer";
  static constexpr Mask<PointCloud2> fields = all<PointCloud2>;
  static void read(const auto& cloud, Use& use) {
    Slam::read(cloud, use);
    use(cloud.height());
  }
};

}  // namespace sft::demo
