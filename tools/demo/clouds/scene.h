// A generated street as a spinning lidar sees it: road, houses, parked cars, posts, and a car that drives by.
// Every call with the same time gives the same bytes.
#pragma once

#include <array>
#include <cstdint>
#include <span>
#include <vector>

namespace sft::demo {

/// A point in the layout of Ouster's ROS driver.
struct LidarPoint {
  float x = 0;  ///< in metres; x, y and z are 0 if nothing was hit
  float y = 0;
  float z = 0;
  float unused_w = 0;
  float intensity = 0;
  std::uint32_t t = 0;  ///< nanoseconds since the scan began
  std::uint16_t reflectivity = 0;
  std::uint16_t ring = 0;  ///< number of the row
  std::uint16_t ambient = 0;
  std::uint16_t unused_after_ambient = 0;
  std::uint32_t range = 0;  ///< in millimetres; 0: nothing was hit
  std::uint32_t unused_at_end[3] = {};
};
static_assert(sizeof(LidarPoint) == 48);

struct Vector {
  float x = 0;
  float y = 0;
  float z = 0;
};

/// A box with faces along the axes, and the light that it reflects (0 to 255).
struct Box {
  Vector low;
  Vector high;
  std::uint8_t reflectivity = 0;
};

class Scene {
 public:
  static constexpr std::uint32_t rows = 128;  ///< row 0 looks up
  static constexpr std::uint32_t columns = 1024;
  static constexpr std::uint32_t points = rows * columns;
  static constexpr std::size_t bytes = points * sizeof(LidarPoint);

  Scene();

  /// Writes the scan at that time into `cloud`, row by row. REQUIRES: cloud.size() == bytes.
  void render(double seconds, std::span<std::uint8_t> cloud) const;

 private:
  struct Hit {
    float range_m = 0;  ///< 0: nothing was hit
    std::uint8_t reflectivity = 0;
  };
  Hit nearest_standing(const Vector& ray) const;
  static LidarPoint point_of(std::uint32_t pixel, const Vector& ray, const Hit& hit, std::uint32_t scan);

  std::vector<Vector> rays_;   // one for each pixel, with length 1
  std::vector<Hit> standing_;  // hits of objects that do not move, computed once
};

}  // namespace sft::demo
