#include "tools/demo/scene.h"

#include <chrono>
#include <cmath>
#include <cstring>
#include <numbers>
#include <vector>

#include "sft/detail/encode.h"
#include "sft/time.h"

namespace sft::demo {

namespace {

using sensor_msgs::msg::PointField;

// The sensor is the origin, and z points up. All lengths are metres.
constexpr float ground_z = -2.0F;
constexpr float wall_z = 6.0F;  // the upper edge
constexpr float wall_distance = 25.0F, wall_depth = 10.0F;
constexpr float wall_waves = 5, wall_speed = 1;  // the distance of the wall as a wave over the azimuth
constexpr float elevation_first_deg = 20.95F, elevation_last_deg = -21.82F;
constexpr std::uint32_t scan_ns = 100'000'000;
constexpr std::uint16_t reflectivity_of_ground = 12, reflectivity_of_wall = 80;

/// The values that all points of a column share.
struct Column {
  float cosine, sine;  ///< cosine and sine of the azimuth
  float wall;          ///< distance of the wall
};

std::vector<Column> columns_at(double seconds) {
  std::vector<Column> columns;
  for (std::uint32_t i = 0; i < Scene::columns; ++i) {
    const float azimuth =
        2 * std::numbers::pi_v<float> * (1 - (static_cast<float>(i) + 0.5F) / Scene::columns);
    const float wave = std::sin(wall_waves * azimuth + wall_speed * static_cast<float>(seconds));
    columns.push_back({std::cos(azimuth), std::sin(azimuth), wall_distance + wall_depth * wave});
  }
  return columns;
}

}  // namespace

void Scene::render(double seconds, std::span<std::uint8_t> cloud) {
  constexpr float degree = std::numbers::pi_v<float> / 180;
  const std::vector<Column> all = columns_at(seconds);
  std::uint8_t* to = cloud.data();
  for (std::uint32_t row = 0; row < rows; ++row) {
    const float share = static_cast<float>(row) / (rows - 1);
    const float elevation = std::lerp(elevation_first_deg, elevation_last_deg, share) * degree;
    const float slope = std::tan(elevation), cosine = std::cos(elevation);
    for (std::uint32_t i = 0; i < columns; ++i, to += sizeof(LidarPoint)) {
      LidarPoint point;
      point.t = static_cast<std::uint32_t>(std::uint64_t{scan_ns} * i / columns);
      point.ring = static_cast<std::uint16_t>(row);
      point.ambient = static_cast<std::uint16_t>(40 + (rows - row));  // the sky is brighter
      const bool is_ground = all[i].wall * slope < ground_z;
      const float distance = is_ground ? ground_z / slope : all[i].wall;
      if (distance * slope <= wall_z) {
        point.x = all[i].cosine * distance;
        point.y = all[i].sine * distance;
        point.z = distance * slope;
        point.reflectivity = is_ground ? reflectivity_of_ground : reflectivity_of_wall;
        point.intensity = point.reflectivity;
        point.range = static_cast<std::uint32_t>(distance / cosine * 1000.0F);
      }
      std::memcpy(to, &point, sizeof point);
    }
  }
}

Scene::Scene() {
  const auto add = [this](const char* name, std::size_t offset, std::uint8_t datatype) {
    layout_.fields.push_back(
        {.name = name, .offset = static_cast<std::uint32_t>(offset), .datatype = datatype, .count = 1});
  };
  add("x", offsetof(LidarPoint, x), PointField::FLOAT32);
  add("y", offsetof(LidarPoint, y), PointField::FLOAT32);
  add("z", offsetof(LidarPoint, z), PointField::FLOAT32);
  add("intensity", offsetof(LidarPoint, intensity), PointField::FLOAT32);
  add("t", offsetof(LidarPoint, t), PointField::UINT32);
  add("reflectivity", offsetof(LidarPoint, reflectivity), PointField::UINT16);
  add("ring", offsetof(LidarPoint, ring), PointField::UINT16);
  add("ambient", offsetof(LidarPoint, ambient), PointField::UINT16);
  add("range", offsetof(LidarPoint, range), PointField::UINT32);
  layout_.header.frame_id = "os_lidar";
  layout_.height = rows;
  layout_.width = columns;
  layout_.point_step = sizeof(LidarPoint);
  layout_.row_step = columns * sizeof(LidarPoint);
  layout_.is_dense = true;
}

/// Computes the cloud in memory that the publisher lends, where readers on this host read it in place.
Result<PublishStatus> Scene::publish(Publisher<PointCloud2>& publisher, double seconds) const {
  using F = PointCloud2::Field;
  Result<Loan<PointCloud2>> loan =
      publisher.loan_for_overwrite(layout_, {.data = static_cast<std::uint32_t>(bytes)});
  if (!loan) return tl::unexpected(loan.error());
  const auto stamp = time_message<builtin_interfaces::msg::Time>(std::chrono::system_clock::now());
  loan->set(F::header.stamp.sec, stamp.sec);
  loan->set(F::header.stamp.nanosec, stamp.nanosec);
  render(seconds, (*loan)->data());
  return std::move(*loan).publish();
}

std::uint64_t Scene::full_bytes() const {
  const TypeSupport& type = type_support<PointCloud2>();
  return detail::encapsulation_bytes + detail::encoded_size(type.type(), &layout_, type.full()).bytes + bytes;
}

}  // namespace sft::demo
