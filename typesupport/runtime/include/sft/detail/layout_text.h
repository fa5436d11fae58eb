// Reads the texts of layouts (layout.h) at compile time, to find the members that the cells of a field
// need. So a mask without one of these members does not compile. selection.md, "Layout rules", explains the
// texts.
#pragma once

#include <cstddef>
#include <string_view>

#include "sft/detail/type_table.h"

namespace sft::detail {

/// The rule of a type that is not annotated. Such types belong to ROS 2, so their files cannot be changed.
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

/// Returns the path of the member that has this role in the rule, "info.width"; empty if no member has it.
constexpr std::string_view path_of_role(std::string_view rule, std::string_view role) {
  while (!rule.empty()) {
    const std::string_view word = rule.substr(0, rule.find(' '));
    if (word.size() > role.size() && word.starts_with(role) && word[role.size()] == '=')
      return word.substr(role.size() + 1);
    rule.remove_prefix(word.size() < rule.size() ? word.size() + 1 : word.size());
  }
  return {};
}

/// Returns true if the name is in the list, which has commas between its names.
constexpr bool is_listed(std::string_view list, std::string_view name) {
  while (!list.empty()) {
    const std::string_view one = list.substr(0, list.find(','));
    if (one == name) return true;
    list.remove_prefix(one.size() < list.size() ? one.size() + 1 : one.size());
  }
  return false;
}

/// Returns the layout rule of that member; empty if the member has no rule.
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

/// Returns the leaf of the member at `path`, counted from the first leaf of the struct; the number of the
/// struct's leaves if there is no such member.
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

/// Returns true if the mask has all fields that are needed to read the cells of a member with this rule.
/// The struct of the member has `first_leaf` as its first leaf.
template <class Mask>
constexpr bool has_fields_of_cells(const Mask& mask, const StructType& type, std::size_t first_leaf,
                                   std::string_view rule) {
  // The rule is that of a list, whose cells are its elements.
  if (path_of_role(rule, "columns").empty()) return true;
  for (const std::string_view role :
       {"rows", "columns", "cell_bytes", "row_bytes", "byte_order", "encoding"}) {
    const std::string_view path = path_of_role(rule, role);
    const std::size_t leaf = path.empty() ? type.leaves : leaf_of_path(type, path);
    if (leaf != type.leaves && !mask.contains(first_leaf + leaf)) return false;
  }
  return true;
}

}  // namespace sft::detail
