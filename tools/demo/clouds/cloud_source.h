// The source of the clouds that the lidar publishes.
#pragma once

#include <cstdint>
#include <memory>
#include <string>

#include <sensor_msgs/msg/PointCloud2.hpp>

#include "sft/publisher.h"

namespace sft::demo {

using sensor_msgs::msg::PointCloud2;

class CloudSource {
 public:
  struct Published {
    PublishStatus status{};
    std::uint64_t full_bytes = 0;  ///< encapsulation and body of the whole message
  };

  virtual ~CloudSource() = default;

  /// Returns a short name for people: a path, or "generated scene".
  virtual std::string name() const = 0;
  /// Returns the size of the clouds for people: "128 x 1024 points".
  virtual std::string shape() const = 0;

  /// Publishes message `number`, counted from 0.
  virtual Result<Published> publish(Publisher<PointCloud2>& publisher, std::uint64_t number) = 0;
};

/// Returns a source of clouds of the generated street. `hz`: the clouds per second of time in the scene.
std::unique_ptr<CloudSource> scene_source(double hz);

/// Returns "128 x 1024 points", or "64,000 points" for a cloud without rows.
std::string format_shape(std::uint32_t height, std::uint32_t width);

const TypeSupport& cloud_type();

/// Returns one channel of the points: `count` numbers of a type that sensor_msgs/PointField names.
sensor_msgs::msg::PointField point_field(std::string_view name, std::uint32_t offset, std::uint8_t datatype,
                                         std::uint32_t count = 1);

}  // namespace sft::demo
