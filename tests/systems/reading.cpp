// A program that reads through temporary views. The values that it reads refer to the sample and not to the
// views, so no compiler must warn.
#include <sft/sft.h>

#include <geometry_msgs/msg/PoseWithCovarianceStamped.hpp>
#include <sensor_msgs/msg/PointCloud2.hpp>
#include <tf2_msgs/msg/TFMessage.hpp>

using geometry_msgs::msg::PoseWithCovarianceStamped;
using sensor_msgs::msg::PointCloud2;
using tf2_msgs::msg::TFMessage;

double sum_of(const sft::Sample<PoseWithCovarianceStamped>& pose) {
  double sum = 0;
  for (const double c : pose->pose().covariance()) sum += c;
  for (const char c : pose->header().frame_id()) sum += c;
  const auto& covariance = pose->pose().covariance();
  const auto& position = pose->pose().pose().position();
  return sum + covariance[0] + position.x();
}

double sum_of(const sft::Sample<TFMessage>& transforms) {
  double sum = 0;
  for (const auto& stamped : transforms->transforms()) {
    sum += stamped.transform().translation().x();
    for (const char c : stamped.header().frame_id()) sum += c;
  }
  for (const char c : transforms->transforms()[0].child_frame_id()) sum += c;
  const auto& first = transforms->transforms()[0];
  return sum + first.transform().translation().y();
}

double sum_of(const sft::Sample<PointCloud2>& cloud) {
  double sum = 0;
  for (const auto byte : cloud->data()) sum += byte;
  for (const auto& field : cloud->fields()) sum += field.count();
  const auto& points = cloud->points<float>("x");
  if (!points) return sum;
  for (const auto& [x] : *points) sum += x;
  return sum;
}

std::size_t size_of(const sft::DynamicSample& sample) {
  std::size_t size = 0;
  for (const auto& member : sample.view()["pose"].members()) size += member.name().size();
  for (const auto& element : sample.view()["transforms"].elements()) size += element.is_struct() ? 1 : 0;
  const auto& covariance = sample.view()["pose"]["covariance"].as<std::span<const double>>();
  const auto& name = sample.view()["pose"].name();
  return size + name.size() + (covariance ? covariance->size() : 0);
}
