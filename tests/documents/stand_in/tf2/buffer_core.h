// The function of ROS 2's tf2 that a recipe of docs/guide.md calls. Debian has tf2 of ROS 1 only.
#pragma once

#include <geometry_msgs/msg/transform_stamped.hpp>
#include <string>

namespace tf2 {

class BufferCore {
 public:
  bool setTransform(const geometry_msgs::msg::TransformStamped& transform, const std::string& authority,
                    bool is_static = false);
};

}  // namespace tf2
