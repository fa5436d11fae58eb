// The points of a cloud as typed columns. The generated view of sensor_msgs::msg::PointCloud2 has a member
// points(), also where the cloud is a member of another message, and points_of() does the same for a view
// without the compiled type:
//
//   if (auto points = sample->points<float, float, float>("x", "y", "z"))
//     for (const auto [x, y, z] : *points) ...
//
//   sft::points_of<float, std::uint16_t>(sample.view().find("cloud"), "x", "ring")
//
// points() reads the cloud in place, whatever else the points have in them: a whole cloud in shared memory,
// or the part with three channels that another host sent. Nothing is copied, and a value is read when it is
// asked for.
//
// The types are those of sensor_msgs/PointField: std::int8_t, std::uint8_t, std::int16_t, std::uint16_t,
// std::int32_t, std::uint32_t, float and double. Each is exactly the type of its channel. The result is an
// error if
//   - the cloud lacks a channel: unknown_field, and the message names the channels that the sample has. A
//     channel without elements, of an unknown type, or that reaches beyond the point counts as lacking.
//   - a channel has another type: type_mismatch
//   - the sample was sent without a field that the points need, which are height, width, all of fields,
//     is_bigendian, point_step, row_step and data, or without a channel that is recorded: unavailable. The
//     subscriber asks for it from then on. If a mask without one of the fields is declared, points() does not
//     compile.
//   - the bytes are not what they claim to be: malformed
// If fields are recorded, so are the channels: a subscriber whose program reads a cloud by points() only is
// sent these channels only. A program that reads `fields`, `point_step`, `row_step` or `data` itself is sent
// whole points. In samples with some channels these four count as not sent. Of clouds whose channels overlap
// whole points are recorded.
// If a channel has several elements, the first one is read. If several channels have one name, the first one
// counts.
// Values of big-endian clouds are swapped. A cloud that claims more points than its data holds is empty.
//
// In templates, as in a callback that takes `const auto& sample`, C++ wants
// `sample->template points<float>("x")`.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cassert>
#include <compare>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <iterator>
#include <ranges>
#include <string_view>
#include <tuple>
#include <utility>

#include "sft/detail/point_grid.h"
#include "sft/result.h"

namespace sft {

namespace detail {

/// The number of a type in sensor_msgs/PointField; 0: there is none.
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

/// An integer of so many bytes.
template <std::size_t Bytes>
using Bits = std::tuple_element_t<std::bit_width(Bytes) - 1,
                                  std::tuple<std::uint8_t, std::uint16_t, std::uint32_t, std::uint64_t>>;

inline std::uint8_t swapped(std::uint8_t bits) { return bits; }
inline std::uint16_t swapped(std::uint16_t bits) { return __builtin_bswap16(bits); }
inline std::uint32_t swapped(std::uint32_t bits) { return __builtin_bswap32(bits); }
inline std::uint64_t swapped(std::uint64_t bits) { return __builtin_bswap64(bits); }

/// Reads some channels of a point.
template <class... Ts>
struct PointReader {
  std::array<std::uint32_t, sizeof...(Ts)> offsets{};  ///< in the point
  bool is_swapped = false;

  std::tuple<Ts...> operator()(const std::byte* point) const {
    return [&]<std::size_t... I>(std::index_sequence<I...>) {
      std::tuple<Ts...> values{value_at<Ts>(point + offsets[I])...};
      if (is_swapped) [[unlikely]]
        ((std::get<I>(values) = swapped(std::get<I>(values))), ...);
      return values;
    }
    (std::index_sequence_for<Ts...>());
  }

 private:
  template <class T>
  static T value_at(const std::byte* at) {
    T value;
    std::memcpy(&value, at, sizeof value);
    return value;
  }
  template <class T>
  static T swapped(T value) {
    return std::bit_cast<T>(detail::swapped(std::bit_cast<Bits<sizeof(T)>>(value)));
  }
};

}  // namespace detail

/// The points of a cloud, each a tuple of the channels that were asked for. It is a range with random access,
/// row by row, that works with std::ranges, and a small value, which is valid as long as the sample. So are
/// its iterators, which do not need the range. Any number of threads may read it. Functions do not throw.
template <class... Ts>
class Points : public std::ranges::view_base {
 public:
  class iterator;
  /// A point.
  using value_type = std::tuple<Ts...>;

  /// Without points.
  Points() = default;
  /// For SFT's own code. The offsets are those of the channels in a point, whose values lie in it.
  Points(const detail::PointGrid& grid, const std::array<std::uint32_t, sizeof...(Ts)>& offsets)
      : grid_(grid), reader_{offsets, grid.is_swapped} {}

  /// The height of the cloud: 1 if the cloud is not organised, and 0 if it contradicts itself.
  std::size_t rows() const { return grid_.rows; }
  /// The width of the cloud, which are the points of a row.
  std::size_t columns() const { return grid_.columns; }
  /// All points.
  std::size_t size() const { return grid_.size(); }
  /// True without points.
  bool empty() const { return size() == 0; }

  /// The point in a row and a column, from 0. REQUIRES: row < rows() and column < columns().
  value_type at(std::size_t row, std::size_t column) const {
    assert(row < rows() && column < columns());
    return reader_(grid_.at(row, column));
  }
  /// The point with this number, from 0, counted row by row. REQUIRES: i < size().
  value_type operator[](std::size_t i) const {
    assert(i < size());
    const std::size_t row = grid_.is_joined() ? 0 : i / grid_.columns;
    return reader_(grid_.at(row, i - row * grid_.columns));
  }
  /// The first point. REQUIRES: !empty().
  value_type front() const { return at(0, 0); }
  /// The last point. REQUIRES: !empty().
  value_type back() const { return at(rows() - 1, columns() - 1); }

  /// Iterates over the points, row by row.
  iterator begin() const { return {grid_.joined(), reader_, 0}; }
  /// The end, behind the last point.
  iterator end() const { return {grid_.joined(), reader_, size()}; }

 private:
  detail::PointGrid grid_{};
  detail::PointReader<Ts...> reader_{};
};

/// A position among the points.
template <class... Ts>
class Points<Ts...>::iterator {
 public:
  using iterator_concept = std::random_access_iterator_tag;
  using iterator_category = std::input_iterator_tag;  // what C++17 asks of one whose elements are values
  using value_type = std::tuple<Ts...>;
  using reference = value_type;
  using difference_type = std::ptrdiff_t;

  iterator() = default;

  value_type operator*() const { return reader_(grid_.first + offset_); }
  value_type operator[](difference_type n) const { return *(*this + n); }

  iterator& operator++() {
    offset_ += grid_.point_step;
    if (offset_ == row_end_) [[unlikely]] {
      offset_ += grid_.row_step - grid_.row_bytes();
      row_end_ += grid_.row_step;
    }
    return *this;
  }
  iterator operator++(int) {
    iterator before = *this;
    ++*this;
    return before;
  }
  iterator& operator--() {
    if (offset_ + grid_.row_bytes() == row_end_) {
      offset_ -= grid_.row_step - grid_.row_bytes();
      row_end_ -= grid_.row_step;
    }
    offset_ -= grid_.point_step;
    return *this;
  }
  iterator operator--(int) {
    iterator before = *this;
    --*this;
    return before;
  }

  iterator& operator+=(difference_type n) {
    move_to(static_cast<std::uint64_t>(position() + n));
    return *this;
  }
  iterator& operator-=(difference_type n) { return *this += -n; }
  friend iterator operator+(iterator i, difference_type n) { return i += n; }
  friend iterator operator+(difference_type n, iterator i) { return i += n; }
  friend iterator operator-(iterator i, difference_type n) { return i -= n; }
  friend difference_type operator-(const iterator& a, const iterator& b) {
    return a.position() - b.position();
  }
  friend bool operator==(const iterator& a, const iterator& b) { return a.offset_ == b.offset_; }
  friend auto operator<=>(const iterator& a, const iterator& b) { return a.offset_ <=> b.offset_; }

 private:
  friend Points;
  iterator(const detail::PointGrid& grid, const detail::PointReader<Ts...>& reader, std::uint64_t position)
      : grid_(grid), reader_(reader) {
    move_to(position);
  }

  void move_to(std::uint64_t position) {
    const std::uint64_t row = position / grid_.columns * grid_.row_step;
    offset_ = row + position % grid_.columns * grid_.point_step;
    row_end_ = row + grid_.row_bytes();
  }
  difference_type position() const {
    const std::uint64_t row = row_end_ - grid_.row_bytes();
    return static_cast<difference_type>(row / grid_.row_step * grid_.columns +
                                        (offset_ - row) / grid_.point_step);
  }

  // Going on changes one number only, so that it stays in a register.
  detail::PointGrid grid_ = detail::PointGrid{}.joined();
  detail::PointReader<Ts...> reader_{};
  std::uint64_t offset_ = 0;                   ///< the bytes from the first point to this one
  std::uint64_t row_end_ = grid_.row_bytes();  ///< and to the end of its row
};

namespace detail {

/// The channels that a program names, with their types.
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

/// The wanted channels of the cloud there.
template <class... Ts>
Result<Points<Ts...>> points_in(const CloudPlace& cloud, std::array<WantedChannel, sizeof...(Ts)>& wanted) {
  const Result<PointGrid> grid = find_points(cloud, wanted);
  if (!grid) return tl::unexpected(grid.error());
  std::array<std::uint32_t, sizeof...(Ts)> offsets{};
  std::ranges::transform(wanted, offsets.begin(), &WantedChannel::offset);
  return Points<Ts...>(*grid, offsets);
}

/// Returns the points for points() of a generated view. The place is that of the view (view.h).
template <class... Ts, class Place, std::convertible_to<std::string_view>... Names>
Result<Points<Ts...>> points_at(const Place& place, const Names&... names) {
  using Struct = typename Place::Struct;
  static_assert(cloud_members<Struct>.has_value(),
                "the fields of this message are not those of sensor_msgs/PointCloud2");
  return [&]<std::size_t... I>(std::index_sequence<I...>)->Result<Points<Ts...>> {
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

/// The points of a cloud that is read by the names of its fields (dynamic_view.h). Valid as long as the
/// sample. Also an error if the view is no cloud: type_mismatch, or the error of the view.
template <class... Ts, std::convertible_to<std::string_view>... Names>
Result<Points<Ts...>> points_of(const DynamicView& cloud, const Names&... names) {
  std::array<detail::WantedChannel, sizeof...(Ts)> wanted = detail::wanted_channels<Ts...>(names...);
  const Result<detail::CloudPlace> place = detail::cloud_place_of(cloud, wanted);
  if (!place) return tl::unexpected(place.error());
  return detail::points_in<Ts...>(*place, wanted);
}

}  // namespace sft

/// @cond not in the reference: Doxygen takes no specialization of what it does not know
template <class... Ts>
inline constexpr bool std::ranges::enable_borrowed_range<sft::Points<Ts...>> = true;
/// @endcond
