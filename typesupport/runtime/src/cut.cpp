#include "sft/detail/cut.h"

#include <algorithm>
#include <bit>
#include <concepts>
#include <limits>
#include <optional>
#include <string_view>
#include <type_traits>
#include <utility>

#include "pixels.h"

namespace sft::detail {

namespace {

constexpr std::uint32_t u32_max = std::numeric_limits<std::uint32_t>::max();

std::uint32_t offset_of(const SampleState& s, std::uint32_t slot) {
  return __atomic_load_n(s.index + slot, __ATOMIC_RELAXED);
}

template <class T>
std::optional<T> read_at(const SampleState& s, std::uint64_t offset) {
  const std::uint32_t at = offset == no_offset ? no_offset : checked_block(s, offset, 1, sizeof(T));
  if (at == no_offset) return {};
  if constexpr (std::integral<T>) {
    return read_once<T>(s.body + at);
  } else {
    using Bits = std::conditional_t<sizeof(T) == sizeof(float), std::uint32_t, std::uint64_t>;
    return std::bit_cast<T>(read_once<Bits>(s.body + at));
  }
}

/// Returns the number in a field; `or_else` if the layout has no such field.
std::optional<std::uint32_t> natural_at(const SampleState& s, const Layout::Field& field,
                                        std::uint64_t or_else) {
  if (!field) return static_cast<std::uint32_t>(std::min<std::uint64_t>(or_else, u32_max));
  return read_at<std::uint32_t>(s, offset_of(s, field.slot));
}

std::optional<double> real_at(const SampleState& s, const Layout::Field& field) {
  if (!field) return 0;
  if (field.member->kind == Kind::float64) return read_at<double>(s, offset_of(s, field.slot));
  const std::optional<float> value = read_at<float>(s, offset_of(s, field.slot));
  return value ? std::optional<double>(*value) : std::nullopt;
}

/// Returns the extent of a text, including its NUL. The length of the text is at `offset`.
Extent text_at(const SampleState& s, std::uint64_t offset) {
  const Extent length = checked_length(s, offset);
  if (!length || checked_block(s, length.first, length.count, 1) == no_offset) return {};
  return length;
}

std::string_view text_of(const SampleState& s, const Extent& with_nul) {
  if (with_nul.count == 0) return {};
  return {reinterpret_cast<const char*>(s.body + with_nul.first), with_nul.count - 1};
}

/// Returns the size in bytes of one value of a channel; 0 if there is no such type. The types are numbered
/// as in sensor_msgs/PointField.
std::uint32_t channel_type_bytes(std::uint8_t type) {
  constexpr std::array<std::uint8_t, 9> bytes{0, 1, 1, 2, 2, 4, 4, 4, 8};
  return type < bytes.size() ? bytes[type] : 0;
}

}  // namespace

void Cut::clear() {
  is_whole_ = false;
  field_bytes_ = 0;
  begin_ = row_stride_ = column_stride_ = 0;
  rows_ = columns_ = cell_bytes_ = 0;
  element_bytes_ = 1;
  pattern_ = nullptr;
  run_count_ = channel_count_ = 0;
}

bool Cut::find_all(const SampleState& s, const Layout& layout, const Layout::Field& data) {
  clear();
  return place_rows(s, layout, data, {});
}

bool Cut::find(const SampleState& s, const Layout* layout, const Layout::Field& data, const Part& part) {
  clear();
  const bool has_rows = layout != nullptr && layout->has_rows();
  return has_rows ? find_rows(s, *layout, data, part) : find_list(s, layout, data, part);
}

std::uint32_t Cut::elements() const { return static_cast<std::uint32_t>(bytes() / element_bytes_); }

std::uint32_t Cut::natural(LayoutRole role) const {
  switch (role) {
    case LayoutRole::rows:
      return rows_;
    case LayoutRole::columns:
      return columns_;
    case LayoutRole::cell_bytes:
      return cell_bytes_;
    default:
      return columns_ * cell_bytes_;
  }
}

bool Cut::find_list(const SampleState& s, const Layout* layout, const Layout::Field& data, const Part& part) {
  // Strings are handled by the projection, which walks over them.
  if (data.member->kind == Kind::string) return true;
  element_bytes_ = static_cast<std::uint32_t>(size_of(data.member->kind));
  const Extent all = checked_sequence(s, offset_of(s, data.slot), element_bytes_);
  if (!all) return false;
  const std::uint64_t row_bytes = std::uint64_t{all.count} * element_bytes_;
  field_bytes_ = row_bytes;
  runs_[0] = {0, element_bytes_};
  run_count_ = 1;
  cell_bytes_ = element_bytes_;
  place({1, all.count, element_bytes_, row_bytes}, all.first, part);
  return layout == nullptr || find_beams(s, *layout, part);
}

bool Cut::find_beams(const SampleState& s, const Layout& layout, const Part& part) {
  const auto first = real_at(s, layout[LayoutRole::first]);
  const auto step = real_at(s, layout[LayoutRole::step]);
  const auto interval = real_at(s, layout[LayoutRole::interval]);
  if (!first || !step || !interval) return false;
  const auto set = [this](LayoutRole role, double value) { reals_[static_cast<std::size_t>(role)] = value; };
  const double begins = *first + part.columns.begin * *step;
  const double new_step = part.columns.step * *step;
  set(LayoutRole::first, begins);
  set(LayoutRole::step, new_step);
  set(LayoutRole::interval, part.columns.step * *interval);
  set(LayoutRole::last, columns_ == 0 ? begins : begins + (columns_ - 1.0) * new_step);
  return true;
}

bool Cut::find_rows(const SampleState& s, const Layout& layout, const Layout::Field& data, const Part& part) {
  if (layout[LayoutRole::scale] && !find_grid(s, layout, part)) return false;
  return place_rows(s, layout, data, part);
}

bool Cut::place_rows(const SampleState& s, const Layout& layout, const Layout::Field& data,
                     const Part& part) {
  element_bytes_ = static_cast<std::uint32_t>(size_of(data.member->kind));
  const Extent all = checked_sequence(s, offset_of(s, data.slot), element_bytes_);
  const auto rows = natural_at(s, layout[LayoutRole::rows], 1);
  const auto columns = natural_at(s, layout[LayoutRole::columns], 1);
  if (!all || !rows || !columns) return false;
  const std::uint64_t data_bytes = std::uint64_t{all.count} * element_bytes_;
  field_bytes_ = data_bytes;
  Size size{*rows, *columns, 0, 0};
  if (!find_cells(s, layout, data_bytes, part, size)) return false;
  if (is_whole_) return true;
  const bool is_empty = *rows == 0 || *columns == 0;
  const std::uint64_t row_end = size.columns * size.cell_bytes;
  // If the data has exactly the bytes of all cells, row_bytes is not used, as in grid_of() in points.cpp.
  const bool is_joined = size.rows > 0 && data_bytes % size.rows == 0 && data_bytes / size.rows == row_end;
  if (is_joined) size.row_bytes = row_end;
  const bool has_room =
      is_empty || (size.cell_bytes > 0 && row_end <= data_bytes &&
                   (size.rows == 1 ||
                    (row_end <= size.row_bytes && (size.rows - 1) * size.row_bytes <= data_bytes - row_end)));
  if (!has_room) size = {0, 0, size.cell_bytes, size.row_bytes};
  if (layout.has_channels() && !part.channels.empty()) {
    if (!find_channels(s, layout, part, size.cell_bytes)) return false;
  } else {
    runs_[0] = {0, static_cast<std::uint32_t>(size.cell_bytes)};
    run_count_ = 1;
    cell_bytes_ = static_cast<std::uint32_t>(size.cell_bytes);
  }
  place(size, all.first, part);
  return true;
}

/// Determines the sizes of cells and rows, and whether a part of them can be taken at all.
bool Cut::find_cells(const SampleState& s, const Layout& layout, std::uint64_t data_bytes, const Part& part,
                     Size& size) {
  const auto cell_bytes = natural_at(s, layout[LayoutRole::cell_bytes], element_bytes_);
  if (!cell_bytes) return false;
  size.cell_bytes = *cell_bytes;
  const auto row_bytes = natural_at(s, layout[LayoutRole::row_bytes], size.columns * size.cell_bytes);
  if (!row_bytes) return false;
  size.row_bytes = *row_bytes;
  if (const Layout::Field& encoding = layout[LayoutRole::encoding]) {
    const Extent text = text_at(s, offset_of(s, encoding.slot));
    if (!text) return false;
    const Pixels pixels = Pixels::of(text_of(s, text));
    const Pixels::Image image{size.rows, size.columns, size.row_bytes, data_bytes};
    size.cell_bytes = pixels.bytes_in(image);
    is_whole_ = is_whole_ || size.cell_bytes == 0 || !pixels.have(part.rows, part.columns, size.columns);
    pattern_ = pixels.pattern_at(part.rows.begin, part.columns.begin);
  }
  return true;
}

/// Computes the new scale, which is the old scale times the step, and the new origin, which is the corner
/// of the part.
bool Cut::find_grid(const SampleState& s, const Layout& layout, const Part& part) {
  const auto scale = real_at(s, layout[LayoutRole::scale]);
  if (!scale) return false;
  is_whole_ = is_whole_ || part.rows.step != part.columns.step;
  reals_[static_cast<std::size_t>(LayoutRole::scale)] = *scale * part.rows.step;
  const Layout::Field& origin = layout[LayoutRole::origin];
  if (!origin) return true;
  std::array<double, 7> pose{};
  for (std::uint32_t i = 0; i < pose.size(); ++i) {
    const auto value = read_at<double>(s, offset_of(s, origin.slot + i));
    if (!value) return false;
    pose[i] = *value;
  }
  const auto [x, y, z, qx, qy, qz, qw] = pose;
  const double dx = part.columns.begin * *scale;
  const double dy = part.rows.begin * *scale;
  const double norm = qx * qx + qy * qy + qz * qz + qw * qw;
  const double twice = norm > 0 ? 2 / norm : 0;  // the rotation may be absent or not normalised
  position_ = {x + dx - twice * ((qy * qy + qz * qz) * dx - (qx * qy - qw * qz) * dy),
               y + dy + twice * ((qx * qy + qw * qz) * dx - (qx * qx + qz * qz) * dy),
               z + twice * ((qx * qz - qw * qy) * dx + (qy * qz + qw * qx) * dy)};
  return true;
}

bool Cut::find_channels(const SampleState& s, const Layout& layout, const Part& part,
                        std::uint64_t cell_bytes) {
  const Extent all = checked_length(s, offset_of(s, layout[LayoutRole::channels].slot));
  if (!all) return false;
  std::array<bool, Selection::channels_max> is_known{};
  std::uint64_t at = all.first;
  for (std::uint32_t i = 0; i < all.count; ++i) {
    const Extent name = text_at(s, at);
    if (!name) return false;
    const std::uint64_t behind_name = align_up(std::uint64_t{name.first} + name.count, 4);
    const auto offset = read_at<std::uint32_t>(s, behind_name);
    const auto type = read_at<std::uint8_t>(s, behind_name + 4);
    const auto count = read_at<std::uint32_t>(s, behind_name + 8);
    if (!offset || !type || !count) return false;
    at = behind_name + 12;
    const auto wanted = std::ranges::lower_bound(part.channels, text_of(s, name));
    if (wanted == part.channels.end() || *wanted != text_of(s, name)) continue;
    if (std::exchange(is_known[static_cast<std::size_t>(wanted - part.channels.begin())], true)) continue;
    const std::uint64_t bytes = std::uint64_t{channel_type_bytes(*type)} * *count;
    if (bytes == 0 || *offset + bytes > cell_bytes) continue;  // such a channel counts as missing
    channels_[channel_count_++] = {name, *offset, static_cast<std::uint32_t>(bytes), *count, *type};
  }
  pack_channels();
  return true;
}

/// Sorts the channels by offset, and joins neighbouring channels to one run.
void Cut::pack_channels() {
  const std::span<Channel> found(channels_.data(), channel_count_);
  std::ranges::stable_sort(found, {}, &Channel::offset);
  std::uint64_t cell_bytes = 0;
  for (const Channel& channel : found) {
    cell_bytes += channel.bytes;
    if (run_count_ > 0 &&
        runs_[run_count_ - 1].offset + std::uint64_t{runs_[run_count_ - 1].bytes} == channel.offset) {
      runs_[run_count_ - 1].bytes += channel.bytes;
    } else {
      runs_[run_count_++] = {channel.offset, channel.bytes};
    }
  }
  cell_bytes_ = static_cast<std::uint32_t>(std::min<std::uint64_t>(cell_bytes, u32_max));
}

/// Computes the places of the cells. If overlapping channels make the part larger than the field, the part
/// is empty.
void Cut::place(const Size& size, std::uint64_t first, const Part& part) {
  rows_ = part.rows.size_of(static_cast<std::uint32_t>(size.rows));
  columns_ = part.columns.size_of(static_cast<std::uint32_t>(size.columns));
  const bool is_too_large = cell_bytes_ > size.cell_bytes || std::uint64_t{columns_} * cell_bytes_ > u32_max;
  if (is_too_large) rows_ = columns_ = 0;
  begin_ = first + part.rows.begin * size.row_bytes + part.columns.begin * size.cell_bytes;
  row_stride_ = part.rows.step * size.row_bytes;
  column_stride_ = part.columns.step * size.cell_bytes;
}

}  // namespace sft::detail
