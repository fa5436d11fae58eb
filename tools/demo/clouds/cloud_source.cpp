#include "tools/demo/clouds/cloud_source.h"

#include <fmt/format.h>

#include "tools/terminal/units.h"

namespace sft::demo {

std::string format_shape(std::uint32_t height, std::uint32_t width) {
  return height == 1 ? tool::grouped_count_text(width) + " points"
                     : fmt::format("{} x {} points", height, width);
}

const TypeSupport& cloud_type() { return type_support<PointCloud2>(); }

sensor_msgs::msg::PointField point_field(std::string_view name, std::uint32_t offset, std::uint8_t datatype,
                                         std::uint32_t count) {
  return {.name = std::string(name), .offset = offset, .datatype = datatype, .count = count};
}

}  // namespace sft::demo
