// A message type as the runtime uses it: its table flattened once, when a topic is opened.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "sft/mask.h"
#include "sft/result.h"
#include "sft/type.h"

namespace sft {

/// A message type: its leaf fields, their paths, and masks of them. Immutable: any thread.
class TypeSupport {
 public:
  /// `type` must outlive this; generated tables are static.
  explicit TypeSupport(const StructType& type);

  /// The tables that it was made of.
  const StructType& type() const { return *type_; }
  /// As in the IDL: "sensor_msgs::msg::Imu".
  std::string_view name() const { return type_->name; }
  /// How many leaf fields the type has.
  std::size_t leaves() const { return paths_.size(); }
  /// How many entries the index of a sample has.
  std::size_t slots() const { return slots_; }

  /// FNV-1a over the canonical structure (names, kinds, shapes, bounds, keys, enumerators; not units): equal
  /// for compatible types.
  std::uint64_t hash() const { return hash_; }

  /// "header.stamp.sec", "fields.size", "fields[].name"
  const std::string& path(std::size_t leaf) const { return paths_[leaf]; }

  /// The mask of a leaf or an inner node by its path; inner nodes mean all leaves below. The error names the
  /// nearest existing field.
  Result<FieldMask> find(std::string_view path) const;
  /// Several paths, separated by commas and spaces; "*" means all.
  Result<FieldMask> parse_mask(std::string_view text) const;
  /// Shortest list of paths that names exactly `mask`: "header, height, fields[].name"; "*" for all, "" for
  /// none.
  std::string format_mask(const FieldMask& mask) const;
  /// The paths of the leaves in `mask`.
  std::vector<std::string> field_names(const FieldMask& mask) const;

  /// What is really sent for `mask`: with any leaf of a sequence's elements goes its length, and key members
  /// always. Closing twice is closing once.
  FieldMask closed(FieldMask mask) const;

  /// The mask without a field.
  FieldMask none() const { return FieldMask(leaves()); }
  /// The mask of all fields.
  FieldMask full() const { return FieldMask::full(leaves()); }

 private:
  struct Node {  ///< an inner node or a leaf of the tree, in depth-first order
    std::string path;
    std::size_t first;
    std::size_t count;
    bool is_leaf;
  };
  void flatten(const StructType& type, const std::string& prefix);
  void add_keys(const StructType& type, std::size_t leaf, FieldMask& mask) const;
  void add_lengths(const StructType& type, std::size_t leaf, FieldMask& mask) const;

  const StructType* type_;
  std::vector<std::string> paths_;
  std::vector<Node> nodes_;
  std::size_t slots_ = 0;
  std::uint64_t hash_ = 0;
};

/// That of a generated message type, made on first use: the numbers, names and text of its fields.
template <class T>
const TypeSupport& type_support() {
  static const TypeSupport support(detail::TypeTable<T>::type);
  return support;
}

/// As TypeSupport::format_mask: of a Mask<T>, a combination of fields or the name of one.
template <detail::FieldSet F>
std::string to_string(const F& fields) {
  return type_support<detail::TypeOfFields<F>>().format_mask(FieldMask(fields));
}
/// Of a mask of T at run time: `sft::to_string<PointCloud2>(sample.mask())`.
template <class T>
std::string to_string(const FieldMask& mask) {
  return type_support<T>().format_mask(mask);
}

}  // namespace sft
