#include <chrono>
#include <cstddef>

#include "sft/detail/encode.h"
#include "sft/time.h"
#include "tools/demo/clouds/cloud_source.h"
#include "tools/demo/clouds/scene.h"

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

/// Returns the bytes of the encapsulation and the body of a cloud with all points.
std::uint64_t full_bytes(const PointCloud2& prototype) {
  const auto reservations = PointCloud2::LoanView<detail::LoanedPlace<PointCloud2>>::reservations(
      {.data = std::uint32_t{Scene::bytes}});
  const TypeSupport& type = cloud_type();
  return detail::encapsulation_bytes +
         detail::encoded_size(type.type(), &prototype, type.full(), reservations).bytes;
}

/// Computes each cloud in memory that the publisher lends, where readers on this host read it in place.
class SceneSource final : public CloudSource {
 public:
  explicit SceneSource(double hz) : hz_(hz), prototype_(cloud_without_points()) {}

  std::string name() const override { return "generated scene"; }
  std::string shape() const override { return format_shape(Scene::rows, Scene::columns); }
  Result<Published> publish(Publisher<PointCloud2>& publisher, std::uint64_t number) override {
    using F = PointCloud2::Field;
    Result<Loan<PointCloud2>> loan =
        publisher.loan_for_overwrite(prototype_, {.data = std::uint32_t{Scene::bytes}});
    if (!loan) return tl::unexpected(loan.error());
    const auto stamp = time_message<builtin_interfaces::msg::Time>(std::chrono::system_clock::now());
    loan->set(F::header.stamp.sec, stamp.sec);
    loan->set(F::header.stamp.nanosec, stamp.nanosec);
    scene_.render(static_cast<double>(number) / hz_, (*loan)->data());
    return Published{std::move(*loan).publish(), full_bytes(prototype_)};
  }

 private:
  const double hz_;
  const Scene scene_;
  const PointCloud2 prototype_;  // all but the points
};

}  // namespace

std::unique_ptr<CloudSource> scene_source(double hz) { return std::make_unique<SceneSource>(hz); }

}  // namespace sft::demo
