#include "tools/demo/clouds/scene_source.h"

#include <chrono>
#include <cstddef>

#include "sft/typesupport/encode.h"

namespace sft::demo {

namespace {

using sensor_msgs::msg::PointField;

PointCloud2 cloud_without_points() {
  PointCloud2 cloud;
  cloud.header.frame_id = "os_lidar";
  cloud.height = Scene::rows;
  cloud.width = Scene::columns;
  cloud.fields = {
      point_field("x", offsetof(LidarPoint, x), PointField::FLOAT32),
      point_field("y", offsetof(LidarPoint, y), PointField::FLOAT32),
      point_field("z", offsetof(LidarPoint, z), PointField::FLOAT32),
      point_field("intensity", offsetof(LidarPoint, intensity), PointField::FLOAT32),
      point_field("t", offsetof(LidarPoint, t), PointField::UINT32),
      point_field("reflectivity", offsetof(LidarPoint, reflectivity), PointField::UINT16),
      point_field("ring", offsetof(LidarPoint, ring), PointField::UINT16),
      point_field("ambient", offsetof(LidarPoint, ambient), PointField::UINT16),
      point_field("range", offsetof(LidarPoint, range), PointField::UINT32),
  };
  cloud.point_step = sizeof(LidarPoint);
  cloud.row_step = Scene::columns * sizeof(LidarPoint);
  cloud.is_dense = true;
  return cloud;
}

/// Encapsulation and body of a cloud with all points.
std::uint64_t full_bytes(const PointCloud2& prototype) {
  const auto reservations =
      PointCloud2::LoanView<LoanedPlace<PointCloud2>>::reservations({.data = std::uint32_t{Scene::bytes}});
  const TypeSupport& type = cloud_type();
  return encapsulation_bytes + encoded_size(type.type(), &prototype, type.full(), reservations).bytes;
}

}  // namespace

SceneSource::SceneSource(double hz) : hz_(hz), prototype_(cloud_without_points()) {}

Result<CloudSource::Published> SceneSource::publish(Publisher<PointCloud2>& publisher, std::uint64_t number) {
  using F = PointCloud2::Field;
  Result<Loan<PointCloud2>> loan =
      publisher.loan_for_overwrite(prototype_, {.data = std::uint32_t{Scene::bytes}});
  if (!loan) return tl::unexpected(loan.error());

  const auto now = std::chrono::system_clock::now().time_since_epoch();
  const auto seconds = std::chrono::floor<std::chrono::seconds>(now);
  loan->set(F::header.stamp.sec, static_cast<std::int32_t>(seconds.count()));
  loan->set(F::header.stamp.nanosec,
            static_cast<std::uint32_t>(std::chrono::nanoseconds(now - seconds).count()));
  scene_.render(static_cast<double>(number) / hz_, (*loan)->data());

  return Published{std::move(*loan).publish(), full_bytes(prototype_)};
}

}  // namespace sft::demo
