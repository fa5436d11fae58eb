#include "tools/demo/clouds/scene.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

namespace sft::demo {

namespace {

// The sensor is the origin, and z points up. All lengths are metres.
constexpr float ground_z = -2.0F;
constexpr float wall_z = 6.0F;  // the upper edge
constexpr float wall_distance = 25.0F, wall_depth = 10.0F;
constexpr float wall_waves = 5, wall_speed = 1;  // the distance of the wall as a wave over the azimuth
constexpr double elevation_first_deg = 20.95, elevation_last_deg = -21.82;
constexpr std::uint32_t scan_ns = 100'000'000;
constexpr std::uint16_t reflectivity_of_ground = 12, reflectivity_of_wall = 80;

}  // namespace

Scene::Scene() {
  constexpr double degree = std::numbers::pi / 180;
  const auto direction = [](double angle) {
    return Direction{static_cast<float>(std::cos(angle)), static_cast<float>(std::sin(angle))};
  };
  const double step = (elevation_last_deg - elevation_first_deg) / (rows - 1);
  for (std::uint32_t row = 0; row < rows; ++row)
    elevations_.push_back(direction((elevation_first_deg + step * row) * degree));
  for (std::uint32_t column = 0; column < columns; ++column)
    azimuths_.push_back(direction(2 * std::numbers::pi * (1.0 - (column + 0.5) / columns)));
}

void Scene::render(double seconds, std::span<std::uint8_t> cloud) const {
  std::vector<float> walls;  // the distance of the wall in each column
  for (const Direction& azimuth : azimuths_) {
    const float angle = std::atan2(azimuth.sine, azimuth.cosine);
    walls.push_back(wall_distance +
                    wall_depth * std::sin(wall_waves * angle + wall_speed * static_cast<float>(seconds)));
  }
  std::uint8_t* to = cloud.data();
  for (std::uint32_t row = 0; row < rows; ++row) {
    const Direction& elevation = elevations_[row];
    const float slope = elevation.sine / elevation.cosine;
    for (std::uint32_t column = 0; column < columns; ++column, to += sizeof(LidarPoint)) {
      LidarPoint point;
      point.t = static_cast<std::uint32_t>(std::uint64_t{scan_ns} * column / columns);
      point.ring = static_cast<std::uint16_t>(row);
      point.ambient = static_cast<std::uint16_t>(40 + (rows - row));  // the sky is brighter
      const bool is_ground = walls[column] * slope < ground_z;
      const float distance = is_ground ? ground_z / slope : walls[column];
      if (distance * slope <= wall_z) {
        point.x = azimuths_[column].cosine * distance;
        point.y = azimuths_[column].sine * distance;
        point.z = distance * slope;
        point.reflectivity = is_ground ? reflectivity_of_ground : reflectivity_of_wall;
        point.intensity = point.reflectivity;
        point.range = static_cast<std::uint32_t>(distance / elevation.cosine * 1000.0F);
      }
      std::memcpy(to, &point, sizeof point);
    }
  }
}

}  // namespace sft::demo
