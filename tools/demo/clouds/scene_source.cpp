#include "tools/demo/clouds/scene_source.h"

#include <chrono>
#include <cstddef>
#include <string>

#include "sft/detail/encode.h"
#include "sft/time.h"

namespace sft::demo {

namespace {

using sensor_msgs::msg::PointField;

PointField point_field(const char* name, std::size_t offset, std::uint8_t datatype) {
  return {.name = name, .offset = static_cast<std::uint32_t>(offset), .datatype = datatype, .count = 1};
}

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

}  // namespace

SceneSource::SceneSource() : prototype_(cloud_without_points()) {}

/// Computes the cloud in memory that the publisher lends, where readers on this host read it in place.
Result<PublishStatus> SceneSource::publish(Publisher<PointCloud2>& publisher, double seconds) const {
  using F = PointCloud2::Field;
  Result<Loan<PointCloud2>> loan =
      publisher.loan_for_overwrite(prototype_, {.data = std::uint32_t{Scene::bytes}});
  if (!loan) return tl::unexpected(loan.error());
  const auto stamp = time_message<builtin_interfaces::msg::Time>(std::chrono::system_clock::now());
  loan->set(F::header.stamp.sec, stamp.sec);
  loan->set(F::header.stamp.nanosec, stamp.nanosec);
  scene_.render(seconds, (*loan)->data());
  return std::move(*loan).publish();
}

std::uint64_t SceneSource::full_bytes() const {
  const auto reservations = PointCloud2::LoanView<detail::LoanedPlace<PointCloud2>>::reservations(
      {.data = std::uint32_t{Scene::bytes}});
  const TypeSupport& type = type_support<PointCloud2>();
  return detail::encapsulation_bytes +
         detail::encoded_size(type.type(), &prototype_, type.full(), reservations).bytes;
}

}  // namespace sft::demo
