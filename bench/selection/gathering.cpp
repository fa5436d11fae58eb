#include <cstring>
#include <sensor_msgs/msg/Image.hpp>
#include <string>

#include "bench/common/contest.h"
#include "bench/common/process.h"
#include "bench/selection/messages.h"
#include "bench/selection/selection.h"
#include "bench/typesupport/messages.h"
#include "sft/detail/project.h"

namespace sft::bench {

namespace {

using namespace detail;
using sensor_msgs::msg::Image;
using sensor_msgs::msg::PointCloud2;

/// Returns an image of 1920 x 1080 pixels of three bytes.
Image colour_image() {
  Image message;
  message.height = 1080;
  message.width = 1920;
  message.encoding = "rgb8";
  message.step = 3 * message.width;
  message.data.assign(std::size_t{message.height} * message.step, 1);
  return message;
}

template <class T>
Figure part_of(const T& message, const std::string& part, std::string name, int rounds,
               std::optional<double> bound = {}) {
  const TypeSupport& type = type_support<T>();
  const ProjectionPlan plan(type, type.closed(type.parse_selection(part).value()));
  const Sample sample(message);
  Projection projection;
  std::vector<std::uint8_t> copy(message.data.size());
  const auto best =
      best_times_ns({batch_of([&] { keep(projection.project(sample.state(), plan)); }),
                     batch_of([&] { std::memcpy(copy.data(), message.data.data(), copy.size()); })},
                    rounds);
  return {std::move(name), best[0] / 1000, "us", best[1] / 1000, "memcpy of all data, for " + part, bound};
}

}  // namespace

std::vector<Figure> gathering_parts(int rounds) {
  pin_to_core(1);
  const PointCloud2 points = ouster_cloud();
  const Image image = colour_image();
  return {part_of(points, "data{x,y,z}", "channels_xyz_gather", rounds, 1.3),
          part_of(points, "data{x,y,z,intensity}[columns ::2]", "channels_every_2nd_column", rounds),
          part_of(points, "data{x,y,z}[rows ::4, columns ::4]", "channels_every_16th_point", rounds),
          part_of(image, "data[rows 270:810, columns 480:1440]", "image_window", rounds),
          part_of(image, "data[rows ::4, columns ::4]", "image_every_16th_pixel", rounds)};
}

}  // namespace sft::bench
