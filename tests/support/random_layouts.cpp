#include "tests/support/random_layouts.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "tests/support/cut_reference.h"

namespace sft::test {

namespace {

using sensor_msgs::msg::Image;
using sensor_msgs::msg::PointCloud2;
using sensor_msgs::msg::PointField;

constexpr std::array names{"x", "y", "z", "intensity", "ring", "t", "rgb"};
constexpr std::array encodings{
    "mono8",        "mono16",       "rgb8",         "bgr8",         "rgba8",       "bgra8",
    "rgb16",        "bgr16",        "rgba16",       "bgra16",       "8UC1",        "8UC3",
    "8SC2",         "16UC1",        "16SC3",        "32SC1",        "32FC1",       "32FC4",
    "64FC1",        "64FC2",        "bayer_rggb8",  "bayer_bggr8",  "bayer_gbrg8", "bayer_grbg8",
    "bayer_rggb16", "bayer_bggr16", "bayer_gbrg16", "bayer_grbg16", "yuv422",      "yuv422_yuy2",
    "uyvy",         "yuyv",         "nv12",         "nv21",         "nv24",        "",
    "thermal",      "mono8; jpeg"};

}  // namespace

Selection::Range RandomLayouts::range(std::uint32_t count) {
  if (one_in(3)) return {};
  Selection::Range range{.begin = below(count + 2), .step = one_in(2) ? 1 : 1 + below(5)};
  if (one_in(2)) range.end = range.begin + below(count + 2);
  if (one_in(4)) range.begin = 0;
  return range;
}

Selection::Range RandomLayouts::range_with_some(std::uint32_t count) {
  Selection::Range range = this->range(count);
  range.begin %= count;
  range.end = std::max(range.end, range.begin + 1);
  return range;
}

std_msgs::msg::Header RandomLayouts::header() {
  std_msgs::msg::Header header;
  header.stamp.sec = static_cast<std::int32_t>(below(2'000'000'000));
  header.stamp.nanosec = below(1'000'000'000);
  header.frame_id.assign(below(9), 'f');
  return header;
}

template <class Byte>
std::vector<Byte> RandomLayouts::bytes(std::size_t count) {
  std::vector<Byte> result(count);
  for (Byte& byte : result) byte = static_cast<Byte>(random_());
  return result;
}

void RandomLayouts::add_odd_channels(PointCloud2& cloud) {
  constexpr std::array<std::uint8_t, 3> no_types{0, 9, 255};
  for (std::uint32_t left = below(7); left > 0; --left) {
    PointField field;
    field.name = one_in(8) ? "" : names[below(names.size())];
    field.offset = below(cloud.point_step + 3);
    field.datatype = one_in(8) ? no_types[below(3)] : static_cast<std::uint8_t>(1 + below(8));
    field.count = one_in(3) ? below(5) : 1;
    cloud.fields.insert(cloud.fields.begin() + below(cloud.fields.size() + 1), field);
  }
}

PointCloud2 RandomLayouts::cloud() {
  PointCloud2 cloud;
  cloud.header = header();
  cloud.height = one_in(2) ? 1 : rows_or_columns();
  cloud.width = cloud.height > 20 ? 1 + below(16) : rows_or_columns();
  std::uint32_t offset = one_in(2) ? 0 : below(6);
  for (const char* name : {"x", "y", "z"}) {
    if (one_in(12)) continue;
    PointField field;
    field.name = name;
    field.offset = offset;
    field.datatype = one_in(4) ? PointField::FLOAT64 : PointField::FLOAT32;
    field.count = 1;
    offset += field.datatype == PointField::FLOAT64 ? 8 : 4;
    cloud.fields.push_back(field);
  }
  cloud.point_step = std::max(offset + below(20), 1U);
  if (!one_in(3)) add_odd_channels(cloud);
  if (one_in(4)) std::ranges::shuffle(cloud.fields, random_);
  cloud.row_step = cloud.width * cloud.point_step + (one_in(3) ? below(9) : 0);
  cloud.data = bytes<std::uint8_t>(std::size_t{cloud.height} * cloud.row_step + (one_in(4) ? below(7) : 0));
  cloud.is_bigendian = one_in(4);
  cloud.is_dense = one_in(2);
  return cloud;
}

std::vector<std::string> RandomLayouts::channels() {
  std::vector<std::string> result;
  for (const char* name : names) {
    if (one_in(2)) result.emplace_back(name);
  }
  if (one_in(3)) result.emplace_back("absent");
  return result;
}

Image RandomLayouts::image() { return image(encodings[below(encodings.size())]); }

Image RandomLayouts::image(const std::string& encoding) {
  Image image;
  image.header = header();
  image.encoding = encoding;
  image.height = rows_or_columns();
  image.width = image.height > 20 ? 1 + below(16) : rows_or_columns();
  image.is_bigendian = static_cast<std::uint8_t>(below(2));
  const std::optional<std::size_t> known = cut_reference::bytes_of_encoding(encoding);
  const auto pixel = static_cast<std::uint32_t>(known.value_or(1 + below(5)));
  const bool is_of_pairs = encoding.starts_with("yuv") || encoding == "uyvy" || encoding == "yuyv";
  if (is_of_pairs && !one_in(8)) image.width += image.width % 2;
  image.step = image.width * pixel + (one_in(3) ? below(9) : 0);
  image.data = bytes<std::uint8_t>(std::size_t{image.height} * image.step + (one_in(4) ? below(7) : 0));
  return image;
}

nav_msgs::msg::OccupancyGrid RandomLayouts::grid() {
  nav_msgs::msg::OccupancyGrid grid;
  grid.header = header();
  grid.info.map_load_time.sec = static_cast<std::int32_t>(below(2'000'000'000));
  grid.info.height = rows_or_columns();
  grid.info.width = rows_or_columns();
  grid.info.resolution = one_in(3) ? 0.05F : static_cast<float>(between(0.01, 2));
  grid.info.origin.position.x = between(-100, 100);
  grid.info.origin.position.y = between(-100, 100);
  grid.info.origin.position.z = one_in(2) ? 0 : between(-5, 5);
  std::array<double, 4> q{0, 0, 0, 1};
  if (!one_in(3)) {
    const bool is_flat = one_in(2);
    for (std::size_t i = is_flat ? 2 : 0; i < 4; ++i) q[i] = between(-1, 1);
    q[3] += q[3] < 0 ? -0.1 : 0.1;
  }
  const double length = std::sqrt(q[0] * q[0] + q[1] * q[1] + q[2] * q[2] + q[3] * q[3]);
  grid.info.origin.orientation.x = q[0] / length;
  grid.info.origin.orientation.y = q[1] / length;
  grid.info.origin.orientation.z = q[2] / length;
  grid.info.origin.orientation.w = q[3] / length;
  const std::size_t cells = std::size_t{grid.info.height} * grid.info.width;
  grid.data = bytes<std::int8_t>(cells + (one_in(4) ? below(7) : 0));
  return grid;
}

sensor_msgs::msg::LaserScan RandomLayouts::scan() {
  sensor_msgs::msg::LaserScan scan;
  scan.header = header();
  const std::uint32_t beams = one_in(4) ? 1 + below(2000) : 1 + below(20);
  const double increment = between(1e-4, 6.0 / beams) * (one_in(4) ? -1 : 1);
  scan.angle_min = static_cast<float>(between(-3.2, 3.2));
  scan.angle_increment = static_cast<float>(increment);
  scan.angle_max = static_cast<float>(double{scan.angle_min} + (beams - 1) * double{scan.angle_increment});
  scan.time_increment = static_cast<float>(between(0, 1e-4));
  scan.scan_time = static_cast<float>(between(0, 0.1));
  scan.range_min = 0.02F;
  scan.range_max = 30;
  const bool has_intensities = !one_in(3);
  for (std::uint32_t i = 0; i < beams; ++i) {
    scan.ranges.push_back(one_in(9) ? INFINITY : static_cast<float>(between(0, 30)));
    if (has_intensities) scan.intensities.push_back(static_cast<float>(between(0, 255)));
  }
  return scan;
}

}  // namespace sft::test
