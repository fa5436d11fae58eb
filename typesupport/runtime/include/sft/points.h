// The points of a cloud as typed columns. The generated view of sensor_msgs::msg::PointCloud2 has a member
// points(), even if the cloud is a member of another message. points_of() does the same for a view
// without the compiled type:
//
//   if (auto points = sample->points<float, float, float>("x", "y", "z"))
//     for (const auto [x, y, z] : *points) ...
//
//   sft::points_of<float, std::uint16_t>(sample.view().find("cloud"), "x", "ring")
//
// The points are Cells (cells.h). Each point is a tuple of the requested channels, and the result has the
// rows of the cloud. points() reads the cloud in place, whatever other channels the points have: a whole
// cloud in shared memory, or the part with three channels that another host sent. Nothing is copied, and a
// value is read only when it is accessed.
//
// The types are those of sensor_msgs/PointField: std::int8_t, std::uint8_t, std::int16_t, std::uint16_t,
// std::int32_t, std::uint32_t, float and double. Each must be exactly the type of its channel. The result is
// an error if
//   - the cloud lacks a channel: unknown_field, and the message names the channels that the sample has. A
//     channel without elements, of an unknown type, or that reaches beyond the point counts as lacking.
//   - a channel has another type: type_mismatch
//   - the sample was sent without a field that the points need, which are height, width, all of fields,
//     is_bigendian, point_step, row_step and data, or without a channel that is recorded: unavailable. The
//     subscriber requests this field or channel from then on. If a mask without one of the fields is
//     declared, points() does not compile.
//   - the bytes of the sample are inconsistent or end early: malformed
// If fields are recorded, channels are recorded, too: if a program reads a cloud only by points(), only the
// channels that it names there are sent. If a program reads `fields`, `point_step`, `row_step` or `data`
// itself, whole points are sent. In a sample with only some channels, these four fields count as not sent.
// If channels of a cloud overlap, whole points are recorded.
// If a channel has several elements, the first element is read. If several channels have one name, the
// first of these channels is read.
// Values of big-endian clouds are swapped. A cloud with fewer bytes of data than its points need is empty.
//
// In templates, as in a callback that takes `const auto& sample`, C++ requires
// `sample->template points<float>("x")`.
#pragma once

#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string_view>
#include <tuple>
#include <utility>

#include "sft/cells.h"
#include "sft/detail/point_grid.h"
#include "sft/result.h"

namespace sft {

namespace detail {

/// Returns the number of the type in sensor_msgs/PointField; 0 if the type has no number.
template <class T>
constexpr std::uint8_t point_type() {
  if (std::same_as<T, std::int8_t>) return 1;
  if (std::same_as<T, std::uint8_t>) return 2;
  if (std::same_as<T, std::int16_t>) return 3;
  if (std::same_as<T, std::uint16_t>) return 4;
  if (std::same_as<T, std::int32_t>) return 5;
  if (std::same_as<T, std::uint32_t>) return 6;
  if (std::same_as<T, float>) return 7;
  if (std::same_as<T, double>) return 8;
  return 0;
}

/// Reads the wanted channels of a point.
template <class... Ts>
struct CellReader<std::tuple<Ts...>> {
  std::array<std::uint32_t, sizeof...(Ts)> offsets{};  ///< the offset of each channel in the point
  bool is_swapped = false;

  std::tuple<Ts...> operator()(const std::byte* point) const {
    return [&]<std::size_t... I>(std::index_sequence<I...>) {
      std::tuple<Ts...> values;
      (read_value(point + offsets[I], std::get<I>(values)), ...);
      if (is_swapped) [[unlikely]]
        (swap_bytes(std::get<I>(values)), ...);
      return values;
    }
    (std::index_sequence_for<Ts...>());
  }
};

/// Returns the channels that a program names, with their types.
template <class... Ts, std::convertible_to<std::string_view>... Names>
std::array<WantedChannel, sizeof...(Ts)> wanted_channels(const Names&... names) {
  static_assert(sizeof...(Ts) > 0 && ((point_type<Ts>() != 0) && ...),
                "points() takes the types of channels, which are those of sensor_msgs/PointField: int8_t to "
                "int32_t, uint8_t to uint32_t, float, double");
  static_assert(sizeof...(Names) == sizeof...(Ts), "points() takes the name of a channel for each type");
  if constexpr (sizeof...(Names) == sizeof...(Ts)) {
    return {WantedChannel{names, point_type<Ts>()}...};
  } else {
    return {};
  }
}

/// Returns the wanted channels of the cloud.
template <class... Ts>
Result<Cells<std::tuple<Ts...>>> points_in(const CloudPlace& cloud,
                                           std::array<WantedChannel, sizeof...(Ts)>& wanted) {
  const Result<CellGrid> grid = find_points(cloud, wanted);
  if (!grid) return tl::unexpected(grid.error());
  std::array<std::uint32_t, sizeof...(Ts)> offsets{};
  std::ranges::transform(wanted, offsets.begin(), &WantedChannel::offset);
  return Cells<std::tuple<Ts...>>(*grid, {offsets, grid->is_swapped});
}

/// Returns the points for points() of a generated view, whose place (view.h) is passed.
template <class... Ts, class Place, std::convertible_to<std::string_view>... Names>
Result<Cells<std::tuple<Ts...>>> points_at(const Place& place, const Names&... names) {
  using Struct = typename Place::Struct;
  static_assert(cloud_members<Struct>.has_value(),
                "the fields of this message are not those of sensor_msgs/PointCloud2");
  return [&]<std::size_t... I>(std::index_sequence<I...>)->Result<Cells<std::tuple<Ts...>>> {
    static_assert((Place::template has_all<(*cloud_members<Struct>)[I]> && ...),
                  "the declared mask lacks a field that points() needs: height, width, fields, is_bigendian, "
                  "point_step, row_step, data");
    std::array<WantedChannel, sizeof...(Ts)> wanted = wanted_channels<Ts...>(names...);
    if constexpr (Place::may_lack) {
      constexpr CloudLeaves leaves{
          LeafRange{Place::template leaf_of<(*cloud_members<Struct>)[I]>,
                    leaf_count(TypeTable<Struct>::members[(*cloud_members<Struct>)[I]])}...};
      if (const Result<void> sent = note_points(place.state(), leaves, wanted); !sent)
        return tl::unexpected(sent.error());
    }
    return points_in<Ts...>(CloudPlace{&place.state(),
                                       {place.template begin_of<(*cloud_members<Struct>)[I]>()...},
                                       Place::template leaf_of<cloud_members<Struct>->back()>},
                            wanted);
  }
  (std::make_index_sequence<cloud_fields.size()>());
}

}  // namespace detail

/// Returns the points of a cloud that is read by the names of its fields (dynamic_view.h). They are valid as
/// long as the sample. Further errors: type_mismatch if the view is no cloud, and the error of the view.
template <class... Ts, std::convertible_to<std::string_view>... Names>
Result<Cells<std::tuple<Ts...>>> points_of(const DynamicView& cloud, const Names&... names) {
  std::array<detail::WantedChannel, sizeof...(Ts)> wanted = detail::wanted_channels<Ts...>(names...);
  const Result<detail::CloudPlace> place = detail::cloud_place_of(cloud, wanted);
  if (!place) return tl::unexpected(place.error());
  return detail::points_in<Ts...>(*place, wanted);
}

}  // namespace sft
