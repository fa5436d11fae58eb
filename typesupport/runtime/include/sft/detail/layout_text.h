// The texts of layouts (layout.h), as far as a compiler looks at them: which members the cells of a field
// need, so that a mask without one of them does not compile. What the texts mean is in selection.md, "Layout
// rules".
#pragma once

#include <cstddef>
#include <string_view>

#include "sft/detail/type_table.h"

namespace sft::detail {

/// The rule of a type that is not annotated. These are types of ROS 2, of which the files are not ours.
struct KnownRule {
  std::string_view type;
  std::string_view field;
  std::string_view rule;
};
inline constexpr KnownRule known_rules[] = {
    {"sensor_msgs::msg::PointCloud2", "data",
     "rows=height columns=width cell_bytes=point_step row_bytes=row_step channels=fields "
     "byte_order=is_bigendian"},
    {"sensor_msgs::msg::Image", "data",
     "rows=height columns=width row_bytes=step byte_order=is_bigendian encoding=encoding"},
    {"nav_msgs::msg::OccupancyGrid", "data",
     "rows=info.height columns=info.width scale=info.resolution origin=info.origin"},
    {"sensor_msgs::msg::LaserScan", "ranges",
     "first=angle_min last=angle_max step=angle_increment interval=time_increment also=intensities"}};

/// The member that has this role in the rule, "info.width"; empty if none has.
constexpr std::string_view path_of_role(std::string_view rule, std::string_view role) {
  while (!rule.empty()) {
    const std::string_view word = rule.substr(0, rule.find(' '));
    if (word.size() > role.size() && word.starts_with(role) && word[role.size()] == '=')
      return word.substr(role.size() + 1);
    rule.remove_prefix(word.size() < rule.size() ? word.size() + 1 : word.size());
  }
  return {};
}

/// True if the name is in the list, which has commas between its names.
constexpr bool is_listed(std::string_view list, std::string_view name) {
  while (!list.empty()) {
    const std::string_view one = list.substr(0, list.find(','));
    if (one == name) return true;
    list.remove_prefix(one.size() < list.size() ? one.size() + 1 : one.size());
  }
  return false;
}

/// The rule of that member; empty if it has none.
constexpr std::string_view rule_of(const StructType& type, const Member& member) {
  bool is_annotated = false;
  for (const Member& m : type.members) {
    if (m.name == member.name ? !m.layout.empty() : is_listed(path_of_role(m.layout, "also"), member.name))
      return m.layout;
    is_annotated |= !m.layout.empty();
  }
  for (const KnownRule& known : known_rules) {
    if (!is_annotated && known.type == type.name && known.field == member.name) return known.rule;
  }
  return {};
}

/// The leaf of a member, counted from the first of the struct; the number of its leaves if it has no such
/// member.
constexpr std::size_t leaf_of_path(const StructType& type, std::string_view path) {
  const std::string_view name = path.substr(0, path.find('.'));
  std::size_t leaf = 0;
  for (const Member& m : type.members) {
    if (m.name == name) {
      if (name.size() == path.size()) return leaf;
      if (m.kind != Kind::structure || m.shape != Shape::single) break;
      const std::size_t below = leaf_of_path(*m.type, path.substr(name.size() + 1));
      return below == m.type->leaves ? type.leaves : leaf + below;
    }
    leaf += leaf_count(m);
  }
  return type.leaves;
}

/// True if the mask, in which the struct has that first leaf, has all that is needed to read the cells of a
/// member with this rule.
template <class Mask>
constexpr bool has_fields_of_cells(const Mask& mask, const StructType& type, std::size_t first_leaf,
                                   std::string_view rule) {
  if (path_of_role(rule, "columns").empty()) return true;  // a list, whose cells are its elements
  for (const std::string_view role :
       {"rows", "columns", "cell_bytes", "row_bytes", "byte_order", "encoding"}) {
    const std::string_view path = path_of_role(rule, role);
    const std::size_t leaf = path.empty() ? type.leaves : leaf_of_path(type, path);
    if (leaf != type.leaves && !mask.contains(first_leaf + leaf)) return false;
  }
  return true;
}

}  // namespace sft::detail
