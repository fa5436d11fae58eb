#include "tools/demo/clouds/scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numbers>

namespace sft::demo {

namespace {

// The sensor is the origin, z points up. All lengths are metres, all angles radians.
constexpr float ground_z = -2;
constexpr float wall_top_z = 6;
constexpr float wall_distance = 20;
constexpr float wave = 3;
constexpr float circle = 2 * std::numbers::pi_v<float>;
constexpr float elevation_first = 0.366F;
constexpr float elevation_step = -0.747F / (Scene::rows - 1);

/// The direction of a column on the map, and the distance of the wall there.
struct Direction {
  float x, y, wall;
};

Direction direction_of(std::uint32_t column, double seconds) {
  const float azimuth = circle * static_cast<float>(column) / Scene::columns;
  const auto phase = static_cast<float>(std::fmod(seconds, double{circle}));
  return {std::cos(azimuth), std::sin(azimuth), wall_distance + wave * std::sin(5 * azimuth + phase)};
}

}  // namespace

void Scene::render(double seconds, std::span<std::uint8_t> cloud) {
  std::array<Direction, columns> directions;
  for (std::uint32_t column = 0; column < columns; ++column)
    directions[column] = direction_of(column, seconds);
  std::uint8_t* to = cloud.data();
  for (std::uint32_t pixel = 0; pixel < points; ++pixel, to += sizeof(LidarPoint)) {
    const std::uint32_t row = pixel / columns;
    const std::uint32_t column = pixel % columns;
    const float slope = std::tan(elevation_first + elevation_step * static_cast<float>(row));
    const Direction& direction = directions[column];
    const float distance = slope < 0 ? std::min(ground_z / slope, direction.wall) : direction.wall;
    LidarPoint point;
    point.t = 97'656 * column;  // a scan takes 0.1 s
    point.ring = static_cast<std::uint16_t>(row);
    point.ambient = static_cast<std::uint16_t>(40 + rows - row);  // the sky is brighter
    if (distance * slope < wall_top_z) {
      point.x = distance * direction.x;
      point.y = distance * direction.y;
      point.z = distance * slope;
      point.reflectivity = distance < direction.wall ? 12 : 80;
      point.intensity = point.reflectivity;
      point.range = static_cast<std::uint32_t>(1000 * std::hypot(distance, point.z));
    }
    std::memcpy(to, &point, sizeof point);
  }
}

}  // namespace sft::demo
