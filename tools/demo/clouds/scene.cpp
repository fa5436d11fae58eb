#include "tools/demo/clouds/scene.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

namespace sft::demo {

namespace {

// The sensor is the origin, x points along the street, z up. All lengths are metres.
constexpr float ground_z = -2.0F;
constexpr float range_max = 120.0F;
constexpr std::uint8_t road_reflectivity = 12;

constexpr double elevation_first_deg = 20.95;
constexpr double elevation_last_deg = -21.82;
constexpr std::uint32_t scan_ns = 100'000'000;

constexpr Box house(float x, float side, float length, float height, std::uint8_t reflectivity) {
  return {{x, side > 0 ? 9.0F : -21.0F, ground_z},
          {x + length, side > 0 ? 21.0F : -9.0F, ground_z + height},
          reflectivity};
}
constexpr Box car(float x, float y, std::uint8_t reflectivity) {
  return {{x, y - 0.9F, ground_z + 0.2F}, {x + 4.4F, y + 0.9F, ground_z + 1.5F}, reflectivity};
}
constexpr Box post(float x, float y) {
  return {{x, y - 0.1F, ground_z}, {x + 0.2F, y + 0.1F, ground_z + 6.0F}, 180};
}

constexpr std::array standing_boxes{
    house(-70, 1, 18, 9, 60),
    house(-48, 1, 14, 12, 80),
    house(-30, 1, 20, 7, 45),
    house(-6, 1, 16, 10, 70),
    house(14, 1, 22, 8, 90),
    house(42, 1, 25, 13, 55),
    house(-66, -1, 22, 8, 75),
    house(-40, -1, 16, 11, 50),
    house(-20, -1, 18, 6, 95),
    house(6, -1, 12, 14, 65),
    house(22, -1, 24, 9, 40),
    house(50, -1, 20, 7, 85),
    car(-24, 5.5F, 110),
    car(-12, 5.5F, 30),
    car(3, 5.5F, 150),
    car(16, 5.5F, 20),
    car(-31, -5.5F, 90),
    car(-9, -5.5F, 130),
    car(8, -5.5F, 25),
    car(29, -5.5F, 100),
    post(-36, 7.2F),
    post(-16, -7.2F),
    post(4, 7.2F),
    post(24, -7.2F),
};

constexpr float driving_speed = -11.0F;  // m/s: towards the sensor, in the other lane
constexpr float driving_from = 66.0F;
constexpr float driving_distance = 132.0F;

Box driving_car(double seconds) {
  const double way = std::fmod(std::abs(driving_speed) * seconds, static_cast<double>(driving_distance));
  return car(driving_from - static_cast<float>(way), 2.4F, 140);
}

/// Returns the distance from the origin to the box along the ray, whose length is 1; 0 if the ray misses the
/// box.
float distance_to(const Box& box, const Vector& ray) {
  float nearest = 0;
  float farthest = range_max;
  const auto clip = [&](float low, float high, float direction) {
    const float inverse = 1.0F / direction;  // infinite for zero, which compares correctly
    const float to_low = low * inverse;
    const float to_high = high * inverse;
    nearest = std::max(nearest, std::min(to_low, to_high));
    farthest = std::min(farthest, std::max(to_low, to_high));
  };
  clip(box.low.x, box.high.x, ray.x);
  clip(box.low.y, box.high.y, ray.y);
  clip(box.low.z, box.high.z, ray.z);
  return nearest < farthest ? nearest : 0.0F;
}

/// Returns measurement noise of up to 15 mm, which depends on the pixel and the scan only.
float noise_m(std::uint32_t pixel, std::uint32_t scan) {
  std::uint32_t bits = pixel * 2654435761U + scan * 40503U;
  bits = (bits ^ (bits >> 15)) * 2246822519U;
  return (static_cast<float>(bits >> 16) / 65536.0F - 0.5F) * 0.03F;
}

Vector ray_of(std::uint32_t row, std::uint32_t column) {
  constexpr double degree = std::numbers::pi / 180;
  const double step = (elevation_last_deg - elevation_first_deg) / (Scene::rows - 1);
  const double elevation = (elevation_first_deg + step * row) * degree;
  const double azimuth = 2 * std::numbers::pi * (1.0 - (column + 0.5) / Scene::columns);
  return {static_cast<float>(std::cos(elevation) * std::cos(azimuth)),
          static_cast<float>(std::cos(elevation) * std::sin(azimuth)),
          static_cast<float>(std::sin(elevation))};
}

}  // namespace

Scene::Scene() {
  rays_.reserve(points);
  standing_.reserve(points);
  for (std::uint32_t row = 0; row < rows; ++row) {
    for (std::uint32_t column = 0; column < columns; ++column) {
      rays_.push_back(ray_of(row, column));
      standing_.push_back(nearest_standing(rays_.back()));
    }
  }
}

Scene::Hit Scene::nearest_standing(const Vector& ray) const {
  Hit nearest;
  if (const float ground = ground_z / ray.z; ray.z < 0 && ground < range_max)
    nearest = {ground, road_reflectivity};
  for (const Box& box : standing_boxes) {
    const float distance = distance_to(box, ray);
    if (distance > 0 && (nearest.range_m == 0 || distance < nearest.range_m))
      nearest = {distance, box.reflectivity};
  }
  return nearest;
}

LidarPoint Scene::point_of(std::uint32_t pixel, const Vector& ray, const Hit& hit, std::uint32_t scan) {
  const std::uint32_t column = pixel % columns;
  LidarPoint point;
  point.t = static_cast<std::uint32_t>(std::uint64_t{scan_ns} * column / columns);
  point.ring = static_cast<std::uint16_t>(pixel / columns);
  point.ambient = static_cast<std::uint16_t>(40 + (rows - point.ring));  // the sky is brighter
  if (hit.range_m == 0) return point;
  const float range = hit.range_m + noise_m(pixel, scan);
  point.x = ray.x * range;
  point.y = ray.y * range;
  point.z = ray.z * range;
  point.intensity = static_cast<float>(hit.reflectivity);
  point.reflectivity = hit.reflectivity;
  point.range = static_cast<std::uint32_t>(range * 1000.0F);
  return point;
}

void Scene::render(double seconds, std::span<std::uint8_t> cloud) const {
  const Box driving = driving_car(seconds);
  const auto scan = static_cast<std::uint32_t>(std::llround(seconds * 1e9 / scan_ns));
  std::uint8_t* to = cloud.data();
  for (std::uint32_t pixel = 0; pixel < points; ++pixel, to += sizeof(LidarPoint)) {
    const Vector& ray = rays_[pixel];
    Hit hit = standing_[pixel];
    const float distance = distance_to(driving, ray);
    if (distance > 0 && (hit.range_m == 0 || distance < hit.range_m)) hit = {distance, driving.reflectivity};
    const LidarPoint point = point_of(pixel, ray, hit, scan);
    std::memcpy(to, &point, sizeof point);
  }
}

}  // namespace sft::demo
