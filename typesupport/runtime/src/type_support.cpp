#include "sft/type_support.h"

#include <algorithm>
#include <utility>

#include "sft/detail/fnv1a.h"
#include "sft/detail/text.h"
#include "sft/detail/type_shape.h"

namespace sft {

using namespace detail;

namespace {

void add_enumeration(Fnv1a& hash, const EnumType& type) {
  hash.add(std::uint64_t{type.is_bitmask} << 32 | type.enumerators.size());
  for (const Enumerator& e : type.enumerators) {
    hash.add(e.name);
    hash.add(e.value);
  }
}

void add_structure(Fnv1a& hash, const StructType& type) {
  hash.add(type.members.size());
  for (const Member& m : type.members) {
    hash.add(m.name);
    hash.add(static_cast<std::uint64_t>(m.kind) << 16 | static_cast<std::uint64_t>(m.shape) << 8 |
             (m.key ? 1U : 0U));
    hash.add(std::uint64_t{m.count} << 32 | m.bound);
    hash.add(m.string_bound);
    if (m.enumeration != nullptr) add_enumeration(hash, *m.enumeration);
    if (m.type != nullptr) add_structure(hash, *m.type);
  }
}

}  // namespace

std::uint64_t detail::structure_hash(const StructType& type) {
  Fnv1a hash;
  add_structure(hash, type);
  return hash.value();
}

TypeSupport::TypeSupport(const StructType& type)
    : type_(&type), layouts_(layouts_of(type)), slots_(slot_count(type)), hash_(structure_hash(type)) {
  flatten(type, "");
}

void TypeSupport::flatten(const StructType& type, const std::string& prefix) {
  const auto add_leaf = [this](std::string path) {
    nodes_.push_back({path, paths_.size(), 1, true});
    paths_.push_back(std::move(path));
  };
  for (const Member& m : type.members) {
    const std::string path = prefix + std::string(m.name);
    if (m.kind != Kind::structure) {
      add_leaf(path);
      continue;
    }
    nodes_.push_back({path, paths_.size(), leaf_count(m), false});
    if (m.shape == Shape::sequence) add_leaf(path + ".size");
    if (is_collection(m)) nodes_.push_back({path + "[]", paths_.size(), leaf_count(*m.type), false});
    flatten(*m.type, path + (is_collection(m) ? "[]." : "."));
  }
}

Result<FieldMask> TypeSupport::find(std::string_view path) const {
  const auto found =
      std::find_if(nodes_.begin(), nodes_.end(), [&](const Node& n) { return n.path == path; });
  if (found == nodes_.end()) {
    const std::string_view meant = path.substr(0, 255);  // cut off, since a longer path resembles no field
    const auto nearest = std::min_element(nodes_.begin(), nodes_.end(), [&](const Node& a, const Node& b) {
      return edit_distance(a.path, meant) < edit_distance(b.path, meant);
    });
    const std::string hint = nearest == nodes_.end() ? "" : "; did you mean '" + nearest->path + "'?";
    return fail(Errc::unknown_field,
                std::string(name()) + " has no field '" + std::string(path) + "'" + hint);
  }
  FieldMask mask = none();
  for (std::size_t leaf = found->first; leaf < found->first + found->count; ++leaf) mask.insert(leaf);
  return mask;
}

Result<FieldMask> TypeSupport::parse_mask(std::string_view text) const {
  static constexpr std::string_view separators = ", \t\r\n";
  FieldMask mask = none();
  for (std::size_t at = text.find_first_not_of(separators); at != std::string_view::npos;) {
    const std::size_t end = std::min(text.find_first_of(separators, at), text.size());
    const std::string_view path = text.substr(at, end - at);
    const Result<FieldMask> part = path == "*" ? Result<FieldMask>(full()) : find(path);
    if (!part) return part;
    mask |= *part;
    at = text.find_first_not_of(separators, end);
  }
  return mask;
}

std::vector<std::string> TypeSupport::field_names(const FieldMask& mask) const {
  std::vector<std::string> names;
  std::size_t covered = 0;  // leaves below this number are already named
  for (const Node& node : nodes_) {
    if (node.first < covered || !mask.all_of(node.first, node.count)) continue;
    names.push_back(node.path);
    covered = node.first + node.count;
  }
  return names;
}

std::string TypeSupport::format_mask(const FieldMask& mask) const {
  if (mask.is_full()) return "*";
  std::string text;
  for (const std::string& name : field_names(mask)) text += (text.empty() ? "" : ", ") + name;
  return text;
}

FieldMask TypeSupport::closed(FieldMask mask) const {
  add_keys(*type_, 0, mask);
  add_lengths(*type_, 0, mask);
  return mask;
}

Selection TypeSupport::closed(const Selection& selection) const {
  std::vector<Selection::Part> parts(selection.parts().begin(), selection.parts().end());
  FieldMask fields = closed(selection.mask());
  // An added field can make the parts of related fields whole. Each round has fewer parts or more fields
  // than the previous round, so the loop ends.
  for (bool is_changed = !parts.empty(); is_changed;) {
    std::vector<Selection::Part> suited = suited_parts(parts, fields);
    FieldMask with_layouts = closed(with_fields_of_layouts(suited, fields));
    is_changed = suited != parts || with_layouts != fields;
    parts = std::move(suited);
    fields = std::move(with_layouts);
  }
  // With the larger mask, the parts and the gate may exceed the limits of a selection. In that case the
  // parts are left out, and if necessary also the gate.
  return Selection::make(fields, std::move(parts), selection.gate())
      .or_else([&](const Error&) { return Selection::make(fields, {}, selection.gate()); })
      .value_or(fields);
}

/// Returns the parts, without the rows and channels that their fields do not have. An array has a fixed
/// length, and is always whole.
std::vector<Selection::Part> TypeSupport::suited_parts(const std::vector<Selection::Part>& parts,
                                                       const FieldMask& fields) const {
  std::vector<Selection::Part> suited;
  for (Selection::Part part : parts) {
    const Layout::Field field = field_at(*type_, part.leaf);
    const Layout* const layout = layout_of(part.leaf);
    if (!field || field.member->shape != Shape::sequence || field.member->kind == Kind::structure) continue;
    if (layout == nullptr || !layout->has_rows()) part.rows = {};
    if (layout == nullptr || !layout->has_channels()) part.channels.clear();
    part.rule = layout == nullptr ? 0 : layout->rule;
    for (const Layout::Field& other : layout == nullptr ? std::vector<Layout::Field>() : layout->data) {
      if (!fields.contains(other.leaf)) continue;
      const auto its = std::ranges::find(parts, other.leaf, &Selection::Part::leaf);
      const bool has_same_rows = its != parts.end() && (!layout->has_rows() || its->rows == part.rows);
      if (!has_same_rows || its->columns != part.columns) part.rows = part.columns = {};
    }
    if (!part.is_whole()) suited.push_back(std::move(part));
  }
  return suited;
}

/// Returns `fields` and the fields that a part changes or that are needed to understand it.
FieldMask TypeSupport::with_fields_of_layouts(const std::vector<Selection::Part>& parts,
                                              FieldMask fields) const {
  for (const Selection::Part& part : parts) {
    const Layout* const layout = layout_of(part.leaf);
    if (layout == nullptr) continue;
    for (const Layout::Field& field : layout->fields) {
      if (!field) continue;
      for (std::size_t i = 0; i < leaf_count(*field.member); ++i) fields.insert(field.leaf + i);
    }
  }
  return fields;
}

const Layout* TypeSupport::layout_of(std::size_t leaf) const {
  const auto has_leaf = [leaf](const Layout::Field& field) { return field.leaf == leaf; };
  const auto found = std::ranges::find_if(
      layouts_, [&](const Layout& layout) { return std::ranges::any_of(layout.data, has_leaf); });
  return found == layouts_.end() ? nullptr : &*found;
}

/// Adds the key fields as DDS defines them: a key member that is a struct adds its own key members, or all
/// members if it has no key. Keys inside other members are ignored.
void TypeSupport::add_keys(const StructType& type, std::size_t leaf, FieldMask& mask) const {
  const auto is_key = [](const Member& m) { return m.key; };
  for (const Member& m : type.members) {
    const std::size_t leaves = leaf_count(m);
    const bool has_own = m.kind == Kind::structure && m.shape == Shape::single &&
                         std::any_of(m.type->members.begin(), m.type->members.end(), is_key);
    if (m.key && has_own) {
      add_keys(*m.type, leaf, mask);
    } else if (m.key) {
      for (std::size_t i = leaf; i < leaf + leaves; ++i) mask.insert(i);
    }
    leaf += leaves;
  }
}

void TypeSupport::add_lengths(const StructType& type, std::size_t leaf, FieldMask& mask) const {
  for (const Member& m : type.members) {
    const std::size_t leaves = leaf_count(m);
    if (m.kind == Kind::structure) {
      const bool has_length = m.shape == Shape::sequence;
      if (has_length && mask.any_of(leaf, leaves)) mask.insert(leaf);
      add_lengths(*m.type, leaf + (has_length ? 1 : 0), mask);
    }
    leaf += leaves;
  }
}

}  // namespace sft
