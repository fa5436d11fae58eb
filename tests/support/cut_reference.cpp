#include "tests/support/cut_reference.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <set>
#include <string_view>
#include <utility>

namespace sft::test::cut_reference {

namespace {

using nav_msgs::msg::OccupancyGrid;
using sensor_msgs::msg::Image;
using sensor_msgs::msg::LaserScan;
using sensor_msgs::msg::PointCloud2;
using sensor_msgs::msg::PointField;
using Part = Selection::Part;
using Range = Selection::Range;

/// The size of a grid of cells, as the fields of a message give it.
struct DeclaredGrid {
  std::uint64_t rows;
  std::uint64_t columns;
  std::uint64_t cell_bytes;
  std::uint64_t row_bytes;
};

bool contradicts_itself(const DeclaredGrid& declared, std::uint64_t data_bytes) {
  if (declared.rows == 0 || declared.columns == 0) return false;
  if (declared.cell_bytes == 0) return true;
  if (declared.rows > 1 && declared.columns * declared.cell_bytes > declared.row_bytes) return true;
  return (declared.rows - 1) * declared.row_bytes + declared.columns * declared.cell_bytes > data_bytes;
}

/// Returns the bytes of the selected cells, row by row without gaps.
template <class Byte>
std::vector<Byte> cells(const std::vector<Byte>& data, const DeclaredGrid& declared, const Part& part) {
  std::vector<Byte> kept;
  for (const std::size_t row : indices(part.rows, declared.rows)) {
    for (const std::size_t column : indices(part.columns, declared.columns)) {
      for (std::size_t byte = 0; byte < declared.cell_bytes; ++byte)
        kept.push_back(data[row * declared.row_bytes + column * declared.cell_bytes + byte]);
    }
  }
  return kept;
}

std::uint32_t count_of(const Range& range, std::size_t count) {
  return static_cast<std::uint32_t>(indices(range, count).size());
}

bool is_bayer(const std::string& encoding) { return encoding.starts_with("bayer_"); }

bool is_in_pairs(const std::string& encoding) {
  return std::set<std::string>{"yuv422", "yuv422_yuy2", "uyvy", "yuyv"}.contains(encoding);
}

bool is_in_planes(const std::string& encoding) {
  return std::set<std::string>{"nv12", "nv21", "nv24"}.contains(encoding);
}

/// Returns the encoding of a part that begins at an odd row or column. The name "bayer_rggb8" has the colours
/// of two rows, with two letters each.
std::string bayer_from(std::string encoding, bool at_odd_row, bool at_odd_column) {
  char* letters = encoding.data() + std::string_view("bayer_").size();
  if (at_odd_column) {
    std::swap(letters[0], letters[1]);
    std::swap(letters[2], letters[3]);
  }
  if (at_odd_row) {
    std::swap(letters[0], letters[2]);
    std::swap(letters[1], letters[3]);
  }
  return encoding;
}

std::optional<std::size_t> pixel_bytes(const Image& image) {
  if (is_in_planes(image.encoding)) return {};
  if (const std::optional<std::size_t> known = bytes_of_encoding(image.encoding)) return known;
  if (image.width == 0 || image.step == 0 || image.step % image.width != 0) return {};
  if (image.data.size() != std::uint64_t{image.height} * image.step) return {};
  return image.step / image.width;
}

bool breaks_pairs(const Range& columns, std::uint32_t width) {
  return columns.step != 1 || columns.begin % 2 != 0 || std::min(columns.end, width) % 2 != 0;
}

using Vector = std::array<double, 3>;

Vector cross(const Vector& a, const Vector& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

}  // namespace

std::vector<std::size_t> indices(const Range& range, std::size_t count) {
  std::vector<std::size_t> result;
  for (std::size_t i = range.begin; i < count && i < range.end; i += range.step) result.push_back(i);
  return result;
}

std::size_t bytes_of_datatype(std::uint8_t datatype) {
  static const std::map<int, std::size_t> bytes{
      {PointField::INT8, 1},  {PointField::UINT8, 1},  {PointField::INT16, 2},   {PointField::UINT16, 2},
      {PointField::INT32, 4}, {PointField::UINT32, 4}, {PointField::FLOAT32, 4}, {PointField::FLOAT64, 8}};
  const auto found = bytes.find(datatype);
  return found == bytes.end() ? 0 : found->second;
}

std::optional<std::size_t> bytes_of_encoding(const std::string& encoding) {
  static const std::map<std::string, std::size_t> bytes{
      {"mono8", 1},        {"mono16", 2},      {"rgb8", 3},         {"bgr8", 3},         {"rgba8", 4},
      {"bgra8", 4},        {"rgb16", 6},       {"bgr16", 6},        {"rgba16", 8},       {"bgra16", 8},
      {"8UC1", 1},         {"8UC2", 2},        {"8UC3", 3},         {"8UC4", 4},         {"8SC1", 1},
      {"8SC2", 2},         {"8SC3", 3},        {"8SC4", 4},         {"16UC1", 2},        {"16UC2", 4},
      {"16UC3", 6},        {"16UC4", 8},       {"16SC1", 2},        {"16SC2", 4},        {"16SC3", 6},
      {"16SC4", 8},        {"32SC1", 4},       {"32SC2", 8},        {"32SC3", 12},       {"32SC4", 16},
      {"32FC1", 4},        {"32FC2", 8},       {"32FC3", 12},       {"32FC4", 16},       {"64FC1", 8},
      {"64FC2", 16},       {"64FC3", 24},      {"64FC4", 32},       {"bayer_rggb8", 1},  {"bayer_bggr8", 1},
      {"bayer_gbrg8", 1},  {"bayer_grbg8", 1}, {"bayer_rggb16", 2}, {"bayer_bggr16", 2}, {"bayer_gbrg16", 2},
      {"bayer_grbg16", 2}, {"yuv422", 2},      {"yuv422_yuy2", 2},  {"uyvy", 2},         {"yuyv", 2}};
  const auto found = bytes.find(encoding);
  return found == bytes.end() ? std::nullopt : std::optional(found->second);
}

std::vector<PointField> channels_of(const PointCloud2& cloud, const std::vector<std::string>& names) {
  std::vector<PointField> channels;
  std::set<std::string> seen;
  for (const PointField& field : cloud.fields) {
    if (std::ranges::count(names, field.name) == 0 || !seen.insert(field.name).second) continue;
    const std::uint64_t bytes = bytes_of_datatype(field.datatype) * std::uint64_t{field.count};
    if (bytes > 0 && field.offset + bytes <= cloud.point_step) channels.push_back(field);
  }
  std::ranges::stable_sort(channels, {}, &PointField::offset);
  return channels;
}

PointCloud2 cut(const PointCloud2& cloud, const Part& part) {
  const DeclaredGrid declared{cloud.height, cloud.width, cloud.point_step, cloud.row_step};
  PointCloud2 result = cloud;
  result.data.clear();
  result.height = result.width = result.row_step = 0;
  if (contradicts_itself(declared, cloud.data.size())) return result;

  result.height = count_of(part.rows, cloud.height);
  result.width = count_of(part.columns, cloud.width);
  if (part.channels.empty()) {
    result.data = cells(cloud.data, declared, part);
  } else {
    const std::vector<PointField> channels = channels_of(cloud, part.channels);
    const std::vector<std::uint8_t> points = cells(cloud.data, declared, part);
    for (std::size_t point = 0; point < points.size(); point += cloud.point_step) {
      for (const PointField& channel : channels) {
        const std::size_t bytes = bytes_of_datatype(channel.datatype) * channel.count;
        for (std::size_t byte = 0; byte < bytes; ++byte)
          result.data.push_back(points[point + channel.offset + byte]);
      }
    }
    result.fields = channels;
    result.point_step = 0;
    for (PointField& field : result.fields) {
      field.offset = result.point_step;
      result.point_step += static_cast<std::uint32_t>(bytes_of_datatype(field.datatype) * field.count);
    }
  }
  if (result.point_step > cloud.point_step) {
    result.data.clear();
    result.height = result.width = 0;
  }
  result.row_step = result.width * result.point_step;
  return result;
}

Image cut(const Image& image, const Part& part) {
  const std::optional<std::size_t> bytes = pixel_bytes(image);
  if (!bytes) return image;
  const bool has_even_step = part.rows.step % 2 == 0 || part.columns.step % 2 == 0;
  if (is_bayer(image.encoding) && has_even_step) return image;
  if (is_in_pairs(image.encoding) && breaks_pairs(part.columns, image.width)) return image;

  const DeclaredGrid declared{image.height, image.width, *bytes, image.step};
  Image result = image;
  result.data.clear();
  result.height = result.width = result.step = 0;
  if (contradicts_itself(declared, image.data.size())) return result;
  result.height = count_of(part.rows, image.height);
  result.width = count_of(part.columns, image.width);
  result.step = static_cast<std::uint32_t>(result.width * *bytes);
  result.data = cells(image.data, declared, part);
  if (is_bayer(image.encoding))
    result.encoding = bayer_from(image.encoding, part.rows.begin % 2 != 0, part.columns.begin % 2 != 0);
  return result;
}

OccupancyGrid cut(const OccupancyGrid& grid, const Part& part) {
  if (part.rows.step != part.columns.step) return grid;
  const DeclaredGrid declared{grid.info.height, grid.info.width, 1, grid.info.width};
  OccupancyGrid result = grid;
  result.data.clear();
  result.info.height = result.info.width = 0;
  if (contradicts_itself(declared, grid.data.size())) return result;
  result.info.height = count_of(part.rows, grid.info.height);
  result.info.width = count_of(part.columns, grid.info.width);
  result.data = cells(grid.data, declared, part);
  const double resolution = grid.info.resolution;
  result.info.resolution = static_cast<float>(resolution * part.rows.step);

  // A unit quaternion (u, w) rotates v to v + 2 w (u x v) + 2 u x (u x v).
  const auto& q = grid.info.origin.orientation;
  const Vector u{q.x, q.y, q.z};
  const Vector v{part.columns.begin * resolution, part.rows.begin * resolution, 0};
  const Vector once = cross(u, v);
  const Vector twice = cross(u, once);
  auto& position = result.info.origin.position;
  position.x += v[0] + 2 * q.w * once[0] + 2 * twice[0];
  position.y += v[1] + 2 * q.w * once[1] + 2 * twice[1];
  position.z += v[2] + 2 * q.w * once[2] + 2 * twice[2];
  return result;
}

LaserScan cut(const LaserScan& scan, const Selection& selection) {
  const bool has_ranges = selection.mask().contains(ranges_leaf);
  const bool has_intensities = selection.mask().contains(intensities_leaf);
  const Part* of_ranges = selection.part(ranges_leaf);
  const Part* of_intensities = selection.part(intensities_leaf);
  // The range of the beams that are kept. If both fields are selected with different ranges, all beams are
  // kept.
  Range range;
  if (has_ranges && !has_intensities && of_ranges != nullptr) range = of_ranges->columns;
  if (!has_ranges && has_intensities && of_intensities != nullptr) range = of_intensities->columns;
  if (has_ranges && has_intensities && of_ranges != nullptr && of_intensities != nullptr) {
    if (of_ranges->columns == of_intensities->columns) range = of_ranges->columns;
  }
  if (range.is_all()) return scan;

  LaserScan result = scan;
  result.ranges = cut(scan.ranges, range);
  result.intensities = cut(scan.intensities, range);
  const double first = scan.angle_min, increment = scan.angle_increment;
  const std::size_t beams = has_ranges ? scan.ranges.size() : scan.intensities.size();
  const std::vector<std::size_t> kept = indices(range, beams);
  if (!kept.empty()) {
    result.angle_min = static_cast<float>(first + static_cast<double>(kept.front()) * increment);
    result.angle_max = static_cast<float>(first + static_cast<double>(kept.back()) * increment);
  }
  result.angle_increment = static_cast<float>(increment * range.step);
  result.time_increment = static_cast<float>(double{scan.time_increment} * range.step);
  return result;
}

}  // namespace sft::test::cut_reference
