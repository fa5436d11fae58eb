#include "tools/demo/clouds/file_formats.h"

#include <fmt/format.h>

namespace sft::demo {

namespace {
constexpr std::uint32_t point_bytes = 16;
}

Result<std::vector<InputCloud>> read_kitti(std::span<const std::byte> file, std::size_t /*limit*/) {
  using sensor_msgs::msg::PointField;
  if (file.empty()) return fail(Errc::malformed, "there is no point in it");
  if (file.size() % point_bytes != 0) {
    return fail(
        Errc::malformed,
        fmt::format(
            "{} bytes are not a number of points of {} bytes (x, y, z, intensity): truncated? If it is an "
            "encoded message, name it .cdr",
            file.size(), point_bytes));
  }
  return convert(
      1, static_cast<std::uint32_t>(file.size() / point_bytes), point_bytes,
      {point_field("x", 0, PointField::FLOAT32), point_field("y", 4, PointField::FLOAT32),
       point_field("z", 8, PointField::FLOAT32), point_field("intensity", 12, PointField::FLOAT32)},
      file);
}

}  // namespace sft::demo
