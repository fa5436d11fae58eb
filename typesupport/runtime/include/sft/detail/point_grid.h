// Finds the points of a cloud in a sample, and its channels in a point (selection.md, "Points"). The bytes
// may be hostile, and in shared memory they may change while they are read. So each number of the header is
// read once, checked, and stored.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <initializer_list>
#include <optional>
#include <span>
#include <string_view>

#include "sft/detail/cell_grid.h"
#include "sft/detail/type_table.h"
#include "sft/detail/walk.h"
#include "sft/result.h"

namespace sft {

class DynamicView;

namespace detail {

/// The members of a cloud that are needed to find its points.
inline constexpr std::array<std::string_view, 7> cloud_fields{
    "height", "width", "fields", "is_bigendian", "point_step", "row_step", "data"};

/// The numbers of these members in a struct, in the order of cloud_fields.
using CloudMembers = std::array<std::size_t, cloud_fields.size()>;

/// The offsets at which these members begin in a sample, in the order of cloud_fields.
struct CloudPlace {
  const SampleState* sample = nullptr;
  std::array<std::uint64_t, cloud_fields.size()> offsets{};
  std::size_t data_leaf = 0;  ///< the leaf of the member `data`
};

// The following functions are evaluated at compile time. declared_part.h says why they have loops in place
// of std::ranges.

/// Returns true if the members of a struct are exactly single values of these kinds.
constexpr bool has_kinds(const StructType& type, std::initializer_list<Kind> kinds) {
  if (type.members.size() != kinds.size()) return false;
  const Kind* kind = kinds.begin();
  for (const Member& member : type.members) {
    if (member.kind != *kind++ || member.shape != Shape::single) return false;
  }
  return true;
}

/// Returns the number of the member of that name; members.size() if there is no such member.
constexpr std::size_t number_of(std::span<const Member> members, std::string_view name) {
  std::size_t number = 0;
  while (number < members.size() && members[number].name != name) ++number;
  return number;
}

/// Returns true if the type of a member is the type that the cloud field of this number has in sensor_msgs.
constexpr bool fits_cloud_field(const Member& member, std::size_t field) {
  const std::string_view name = cloud_fields[field];
  if (name == "fields") {
    return member.kind == Kind::structure && member.shape == Shape::sequence &&
           has_kinds(*member.type, {Kind::string, Kind::uint32, Kind::uint8, Kind::uint32});
  }
  const bool is_byte = is_primitive(member.kind) && size_of(member.kind) == 1;
  if (name == "data") return is_byte && member.shape == Shape::sequence;
  return (name == "is_bigendian" ? is_byte : member.kind == Kind::uint32) && member.shape == Shape::single;
}

/// Returns the members of a cloud; nothing if the struct is no cloud. The name of a struct is not enough,
/// since a struct of that name may have other fields.
constexpr std::optional<CloudMembers> cloud_members_of(const StructType& type) {
  if (type.name != "sensor_msgs::msg::PointCloud2") return {};
  CloudMembers members{};
  for (std::size_t field = 0; field < members.size(); ++field) {
    const std::size_t number = number_of(type.members, cloud_fields[field]);
    if (number == type.members.size() || !fits_cloud_field(type.members[number], field)) return {};
    members[field] = number;
  }
  return members;
}

/// The members of a cloud whose type is compiled in; nothing if the struct is no cloud.
template <class S>
inline constexpr std::optional<CloudMembers> cloud_members = cloud_members_of(TypeTable<S>::type);

/// A channel that a program requests.
struct WantedChannel {
  std::string_view name;
  /// The number of the type in sensor_msgs/PointField; 0: any type is accepted, and find_points() sets the
  /// type that it finds
  std::uint8_t type;
  // The following members are set by find_points().
  std::uint32_t offset = 0;     ///< the offset in a point
  std::uint8_t found_type = 0;  ///< the type that was found; 0: the channel is missing
  /// the number of elements that are read of each point: 1, or all elements if any type is accepted
  std::uint32_t count = 1;
  bool is_found = false;
};

/// The leaves of the members of a cloud, in the order of cloud_fields.
struct LeafRange {
  std::size_t first = 0;
  std::size_t count = 0;
};
using CloudLeaves = std::array<LeafRange, cloud_fields.size()>;

/// Finds the points of a cloud, and the wanted channels in them. The grid is empty if the cloud contradicts
/// itself.
Result<CellGrid> find_points(const CloudPlace& cloud, std::span<WantedChannel> wanted);

/// If reads are recorded, notes a read of the wanted channels, or of all members of the cloud if its channels
/// are not noted one by one. Returns an error if the sample was sent without one of the members or channels.
Result<void> note_points(const SampleState& s, const CloudLeaves& leaves,
                         std::span<const WantedChannel> wanted);

/// Finds a cloud in a sample whose type is not compiled in, and notes reads like note_points().
Result<CloudPlace> cloud_place_of(const DynamicView& view, std::span<const WantedChannel> wanted);

}  // namespace detail
}  // namespace sft
