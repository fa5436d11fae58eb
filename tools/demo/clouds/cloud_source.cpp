#include "tools/demo/clouds/cloud_source.h"

#include <fmt/format.h>

#include "sft/typesupport/encode.h"
#include "tools/terminal/units.h"

namespace sft::demo {

std::string format_shape(std::uint32_t height, std::uint32_t width) {
  return height == 1 ? tool::grouped_count_text(width) + " points"
                     : fmt::format("{} x {} points", height, width);
}

const TypeSupport& cloud_type() {
  static const TypeSupport type(TypeTable<PointCloud2>::type);
  return type;
}

std::uint64_t full_bytes(const PointCloud2& prototype, std::uint32_t data_bytes) {
  const auto reservations =
      PointCloud2::LoanView<LoanedPlace<PointCloud2>>::reservations({.data = data_bytes});
  const TypeSupport& type = cloud_type();
  return encapsulation_bytes + encoded_size(type.type(), &prototype, type.full(), reservations).bytes;
}

sensor_msgs::msg::PointField point_field(std::string name, std::uint32_t offset, std::uint8_t datatype,
                                         std::uint32_t count) {
  sensor_msgs::msg::PointField field;
  field.name = std::move(name);
  field.offset = offset;
  field.datatype = datatype;
  field.count = count;
  return field;
}

}  // namespace sft::demo
