// The names of the fields of a message type, and masks as text: type_support<T>() for a compiled type,
// DynamicType::support() for any other.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sft/detail/layout.h"
#include "sft/mask.h"
#include "sft/result.h"
#include "sft/selection.h"
#include "sft/type.h"

namespace sft {

/// A type with the paths of its leaves (type.h). It is immutable, and any thread may use it. All numbers of
/// leaves that are passed to its functions must be less than leaves(), and all masks must be of this type.
class TypeSupport {
 public:
  /// Lists the leaves of `type`, which must outlive this object.
  explicit TypeSupport(const StructType& type);

  /// Returns the tables that were passed to the constructor.
  const StructType& type() const { return *type_; }
  /// Returns the name in the IDL: "sensor_msgs::msg::Imu".
  std::string_view name() const { return type_->name; }
  /// Returns the number of leaf fields that the type has.
  std::size_t leaves() const { return paths_.size(); }
  /// For SFT's own code: returns the number of offsets in a sample's index.
  std::size_t index_slots() const { return slots_; }

  /// Returns the FNV-1a hash of the structure (names, kinds, shapes, bounds, keys and enumerators, but no
  /// units). Compatible types have equal hashes.
  std::uint64_t hash() const { return hash_; }

  /// Returns the path of a leaf: "header.stamp.sec", "fields.size", "fields[].name".
  const std::string& path(std::size_t leaf) const { return paths_[leaf]; }

  /// Returns the mask of a leaf by its path. The path of a struct, or of an array or a sequence of structs,
  /// means all leaves in it. The error names the existing field with the most similar name.
  Result<FieldMask> find(std::string_view path) const;
  /// Returns the mask of several paths, separated by commas and spaces; "*" means all fields. Errors are
  /// those of find().
  Result<FieldMask> parse_mask(std::string_view text) const;
  /// Returns the shortest list of paths that names exactly `mask`: "header, height, fields[].name"; "*" for
  /// all fields, "" for none. parse_mask() reads it.
  std::string format_mask(const FieldMask& mask) const;
  /// Returns the paths in the text of format_mask(), one by one.
  std::vector<std::string> field_names(const FieldMask& mask) const;

  /// Returns the selection that the text describes (selection.md). The error begins with the column, from
  /// 1, of the mistake.
  Result<Selection> parse_selection(std::string_view text) const;
  /// Returns the shortest text from which parse_selection() makes exactly this selection: "header.stamp,
  /// data{x,y,z}[:100]". A selection that was received as bytes can have parts and conditions that do not
  /// suit their fields. The text of such a selection is only for people.
  std::string format_selection(const Selection& selection) const;

  /// Returns the fields that are sent for `mask`: `mask`, the length of each sequence of structs of which
  /// the mask has a leaf, and the key members. A closed mask stays the same if it is closed again.
  FieldMask closed(FieldMask mask) const;
  /// Returns the selection that is sent if `selection` is requested. It has the closed mask of the selected
  /// fields, and the fields that a part changes or that are needed to understand the part. Fields that
  /// belong together have the same part (selection.md, "Parts"). A closed selection stays the same if it is
  /// closed again.
  Selection closed(const Selection& selection) const;
  /// For SFT's own code: returns how the field is made of rows and columns; null if the field has no
  /// layout.
  const detail::Layout* layout_of(std::size_t leaf) const;

  /// Returns the mask without any field.
  FieldMask none() const { return FieldMask(leaves()); }
  /// Returns the mask of all fields.
  FieldMask full() const { return FieldMask::full(leaves()); }

 private:
  struct Node {  ///< a node of the tree: an inner node or a leaf; nodes are in depth-first order
    std::string path;
    std::size_t first;
    std::size_t count;
    bool is_leaf;
  };
  void flatten(const StructType& type, const std::string& prefix);
  void add_keys(const StructType& type, std::size_t leaf, FieldMask& mask) const;
  void add_lengths(const StructType& type, std::size_t leaf, FieldMask& mask) const;

  std::vector<Selection::Part> suited_parts(const std::vector<Selection::Part>& parts,
                                            const FieldMask& fields) const;
  FieldMask with_fields_of_layouts(const std::vector<Selection::Part>& parts, FieldMask fields) const;

  const StructType* type_;
  std::vector<detail::Layout> layouts_;
  std::vector<std::string> paths_;
  std::vector<Node> nodes_;
  std::size_t slots_ = 0;
  std::uint64_t hash_ = 0;
};

/// Returns the TypeSupport of a generated message type. The first call makes the object, which lives as
/// long as the program.
template <class T>
const TypeSupport& type_support() {
  static const TypeSupport support(detail::TypeTable<T>::type);
  return support;
}

/// Returns TypeSupport::format_mask() of a Mask<T>, a combination of fields, or the name of a field.
template <detail::FieldSet F>
std::string to_string(const F& fields) {
  return type_support<detail::TypeOfFields<F>>().format_mask(FieldMask(fields));
}
/// Returns TypeSupport::format_mask() of a FieldMask of T: `sft::to_string<PointCloud2>(sample.mask())`.
template <class T>
std::string to_string(const FieldMask& mask) {
  return type_support<T>().format_mask(mask);
}

}  // namespace sft
