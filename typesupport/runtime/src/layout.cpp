#include "sft/detail/layout.h"

#include <algorithm>
#include <optional>
#include <span>
#include <string_view>

namespace sft::detail {

namespace {

struct RoleOf {
  std::string_view path;
  LayoutRole role;
};

/// A layout, by the paths of its fields in a type.
struct KnownLayout {
  std::string_view type;
  Layout::Form form;
  std::array<std::string_view, 2> data;  ///< the second may be empty
  std::span<const RoleOf> roles;
};

constexpr RoleOf cloud_roles[] = {
    {"height", LayoutRole::rows},           {"width", LayoutRole::columns},
    {"fields", LayoutRole::channels},       {"is_bigendian", LayoutRole::byte_order},
    {"point_step", LayoutRole::cell_bytes}, {"row_step", LayoutRole::row_bytes}};
constexpr RoleOf image_roles[] = {{"height", LayoutRole::rows},
                                  {"width", LayoutRole::columns},
                                  {"encoding", LayoutRole::encoding},
                                  {"is_bigendian", LayoutRole::byte_order},
                                  {"step", LayoutRole::row_bytes}};
constexpr RoleOf grid_roles[] = {{"info.resolution", LayoutRole::scale},
                                 {"info.width", LayoutRole::columns},
                                 {"info.height", LayoutRole::rows},
                                 {"info.origin", LayoutRole::origin}};
constexpr RoleOf scan_roles[] = {{"angle_min", LayoutRole::first},
                                 {"angle_max", LayoutRole::last},
                                 {"angle_increment", LayoutRole::step},
                                 {"time_increment", LayoutRole::interval}};
constexpr KnownLayout known_layouts[] = {
    {"sensor_msgs::msg::PointCloud2", Layout::Form::points, {"data"}, cloud_roles},
    {"sensor_msgs::msg::Image", Layout::Form::cells, {"data"}, image_roles},
    {"nav_msgs::msg::OccupancyGrid", Layout::Form::cells, {"data"}, grid_roles},
    {"sensor_msgs::msg::LaserScan", Layout::Form::list, {"ranges", "intensities"}, scan_roles}};

/// A struct, with the numbers of its first leaf and slot.
struct Place {
  const StructType* type;
  std::uint32_t leaf;
  std::uint32_t slot;
};

template <class Visit>
void for_each_member(const Place& place, Visit visit) {
  Layout::Field field{place.leaf, place.slot, nullptr};
  for (const Member& member : place.type->members) {
    field.member = &member;
    visit(field);
    field.leaf += static_cast<std::uint32_t>(leaf_count(member));
    field.slot += static_cast<std::uint32_t>(slot_count(member));
  }
}

Layout::Field find(Place place, std::string_view path) {
  const std::string_view name = path.substr(0, path.find('.'));
  Layout::Field found;
  for_each_member(place, [&](const Layout::Field& field) {
    if (field.member->name == name) found = field;
  });
  if (!found || name.size() == path.size()) return found;
  if (found.member->kind != Kind::structure || found.member->shape != Shape::single) return {};
  return find({found.member->type, found.leaf, found.slot}, path.substr(name.size() + 1));
}

bool is_single(const Member& member, Kind kind) {
  return member.kind == kind && member.shape == Shape::single;
}

bool is_real(const Member& member) {
  return is_single(member, Kind::float32) || is_single(member, Kind::float64);
}

bool has_kinds(const StructType& type, std::span<const Kind> kinds) {
  return std::ranges::equal(type.members, kinds,
                            [](const Member& member, Kind kind) { return is_single(member, kind); });
}

bool is_pose(const StructType& type) {
  constexpr std::array<Kind, 4> reals{Kind::float64, Kind::float64, Kind::float64, Kind::float64};
  return type.members.size() == 2 && type.slots == 7 && is_single(type.members[0], Kind::structure) &&
         is_single(type.members[1], Kind::structure) &&
         has_kinds(*type.members[0].type, std::span(reals).first(3)) &&
         has_kinds(*type.members[1].type, reals);
}

bool fits(const Member& member, LayoutRole role) {
  constexpr std::array channel{Kind::string, Kind::uint32, Kind::uint8, Kind::uint32};
  switch (role) {
    case LayoutRole::rows:
    case LayoutRole::columns:
    case LayoutRole::cell_bytes:
    case LayoutRole::row_bytes:
      return is_single(member, Kind::uint32);
    case LayoutRole::channels:
      return member.kind == Kind::structure && member.shape == Shape::sequence &&
             has_kinds(*member.type, channel);
    case LayoutRole::byte_order:
      return is_primitive(member.kind) && member.shape == Shape::single;
    case LayoutRole::encoding:
      return is_single(member, Kind::string);
    case LayoutRole::origin:
      return is_single(member, Kind::structure) && is_pose(*member.type);
    case LayoutRole::scale:
    case LayoutRole::first:
    case LayoutRole::last:
    case LayoutRole::step:
    case LayoutRole::interval:
      return is_real(member);
  }
  return false;
}

bool is_data(const Member& member, Layout::Form form) {
  return is_primitive(member.kind) && member.shape == Shape::sequence &&
         (form == Layout::Form::list || size_of(member.kind) == 1);
}

/// Nothing if a type of that name has other fields.
std::optional<Layout> layout_at(const Place& place, const KnownLayout& known) {
  Layout layout{.form = known.form};
  for (const std::string_view path : known.data) {
    if (path.empty()) continue;
    const Layout::Field data = find(place, path);
    if (!data || !is_data(*data.member, known.form)) return {};
    layout.data.push_back(data);
  }
  for (const RoleOf& one : known.roles) {
    const Layout::Field field = find(place, one.path);
    if (!field || !fits(*field.member, one.role)) return {};
    layout.fields[static_cast<std::size_t>(one.role)] = field;
  }
  return layout;
}

void add_layouts(const Place& place, std::vector<Layout>& layouts) {
  const auto known = std::ranges::find(known_layouts, place.type->name, &KnownLayout::type);
  if (known != std::end(known_layouts)) {
    if (std::optional<Layout> layout = layout_at(place, *known)) layouts.push_back(std::move(*layout));
  }
  for_each_member(place, [&](const Layout::Field& field) {
    if (is_single(*field.member, Kind::structure))
      add_layouts({field.member->type, field.leaf, field.slot}, layouts);
  });
}

Layout::Field field_in(const Place& place, std::size_t leaf) {
  Layout::Field found;
  for_each_member(place, [&](const Layout::Field& field) {
    if (leaf >= field.leaf && leaf < field.leaf + leaf_count(*field.member)) found = field;
  });
  if (!found || !is_single(*found.member, Kind::structure)) return found;
  return field_in({found.member->type, found.leaf, found.slot}, leaf);
}

}  // namespace

std::optional<LayoutRole> Layout::role_of(std::size_t leaf) const {
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const auto role = static_cast<LayoutRole>(i);
    const std::size_t leaves = role == LayoutRole::origin ? 3 : 1;
    if (fields[i] && leaf >= fields[i].leaf && leaf < fields[i].leaf + leaves) return role;
  }
  return {};
}

Layout::Field field_at(const StructType& type, std::size_t leaf) { return field_in({&type, 0, 0}, leaf); }

std::vector<Layout> layouts_of(const StructType& type) {
  std::vector<Layout> layouts;
  add_layouts({&type, 0, 0}, layouts);
  return layouts;
}

}  // namespace sft::detail
