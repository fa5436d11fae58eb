#include "sft/strides.h"

#include <array>

#include "sft/detail/cell_grid.h"
#include "sft/detail/point_grid.h"

namespace sft {

namespace {

Strides strides_of_grid(const detail::CellGrid& grid) {
  return {.first = grid.first,
          .rows = grid.rows,
          .columns = grid.columns,
          .row_step = grid.row_step,
          .column_step = grid.column_step,
          .is_swapped = grid.is_swapped};
}

/// Returns the kind of a type of sensor_msgs/PointField, where the types are numbered from 1.
detail::Kind kind_of_point_type(std::uint8_t type) {
  using enum detail::Kind;
  constexpr std::array<detail::Kind, 9> kinds{octet, int8,   uint8,   int16,  uint16,
                                              int32, uint32, float32, float64};
  return kinds[type];
}

}  // namespace

Result<Strides> strides_of(const DynamicView& message, std::string_view path, std::size_t cell_bytes) {
  return detail::find_cells(message, path, cell_bytes, [](detail::Kind) { return true; })
      .map(strides_of_grid);
}

Result<Strides> point_strides_of(const DynamicView& cloud, std::span<const std::string_view> names) {
  std::vector<detail::WantedChannel> wanted;
  wanted.reserve(names.size());
  for (const std::string_view name : names) wanted.push_back({.name = name, .type = 0});
  const Result<detail::CloudPlace> place = detail::cloud_place_of(cloud, wanted);
  if (!place) return tl::unexpected(place.error());
  return detail::find_points(*place, wanted).map([&](const detail::CellGrid& grid) {
    Strides strides = strides_of_grid(grid);
    for (const detail::WantedChannel& one : wanted)
      strides.channels.push_back({kind_of_point_type(one.found_type), one.offset, one.count});
    return strides;
  });
}

}  // namespace sft
