// Only generated code includes this file. It has the building blocks of tables, field names and views.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "sft/detail/loan_view.h"
#include "sft/detail/outlives_view.h"
#include "sft/detail/owned_view.h"
#include "sft/detail/point_grid.h"
#include "sft/detail/type_table.h"
#include "sft/detail/view.h"
#include "sft/mask.h"

namespace sft::detail {

/// Returns true if member number M of S contains the points of a cloud.
template <class S, std::size_t M>
constexpr bool has_points() {
  return cloud_members<S> && cloud_members<S>->back() == M;
}

/// Returns true if the leaf is not in an array or sequence of structs.
constexpr bool is_in_no_collection(const StructType& type, std::size_t leaf) {
  for (const Member& member : type.members) {
    const std::size_t leaves = leaf_count(member);
    if (leaf < leaves) {
      return member.kind != Kind::structure ||
             (member.shape == Shape::single && is_in_no_collection(*member.type, leaf));
    }
    leaf -= leaves;
  }
  return false;
}

/// The name of a field that is a sequence of values. It has functions to declare parts (declared_part.h).
/// The field is member number M of S and has the leaf First.
template <class Root, std::size_t First, class S, std::size_t M>
class SequenceNode : public FieldNode<Root, First, 1> {
  static constexpr FieldPart<Root> whole() {
    static_assert(is_in_no_collection(TypeTable<Root>::type, First),
                  "a field of the elements of an array or a sequence has no parts");
    FieldPart<Root> all{.part = {.leaf = First}};
    if constexpr (has_points<S, M>()) {
      for (const std::size_t member : *cloud_members<S>) {
        const std::size_t leaf =
            First - leaf_offset(TypeTable<S>::type, M) + leaf_offset(TypeTable<S>::type, member);
        if (leaf != First)
          all.beside = all.beside | Mask<Root>::range(leaf, leaf_count(TypeTable<S>::members[member]));
      }
    }
    return all;
  }
  template <NameText... Names>
  static constexpr FieldPart<Root> part_with() {
    static_assert(has_points<S, M>(), "only the data of a PointCloud2 has channels");
    FieldPart<Root> some = whole();
    some.part.channels = declared_channels<Names...>();
    return some;
  }

 public:
  static constexpr FieldPart<Root> every(std::uint32_t n) { return whole().every(n); }
  static constexpr FieldPart<Root> range(std::uint32_t begin, std::uint32_t end, std::uint32_t step = 1) {
    return whole().range(begin, end, step);
  }
  static constexpr FieldPart<Root> rows(std::uint32_t begin, std::uint32_t end, std::uint32_t step = 1) {
    return whole().rows(begin, end, step);
  }
  static constexpr FieldPart<Root> columns(std::uint32_t begin, std::uint32_t end, std::uint32_t step = 1) {
    return whole().columns(begin, end, step);
  }
  /// Declares these channels of each point.
  template <NameText... Names>
  static constexpr FieldPart<Root> channels = part_with<Names...>();
};

/// Returns true for a sequence of values, the only kind of field with parts.
constexpr bool may_have_parts(const Member& member) {
  return member.shape == Shape::sequence && member.kind != Kind::structure;
}

/// Base of the generated field names of S, which is at leaf First of Root. It is the node of S itself, and
/// defines the nodes of its members.
template <class Root, std::size_t First, class S>
struct FieldsOf : FieldNode<Root, First, leaf_count_of<S>> {
  template <std::size_t M>
  static constexpr std::size_t first = First + leaf_offset(TypeTable<S>::type, M);
  template <std::size_t M>
  using Leaf =
      std::conditional_t<may_have_parts(TypeTable<S>::members[M]), SequenceNode<Root, first<M>, S, M>,
                         FieldNode<Root, first<M>, leaf_count(TypeTable<S>::members[M])>>;
};

/// The names below a sequence of structs E: `fields` means all its leaves, `fields.size` its length, and
/// `fields.each.name` a leaf of the elements (written `fields[].name` in text).
template <class E, class Root, std::size_t First>
struct SequenceFields : FieldNode<Root, First, 1 + leaf_count_of<E>> {
  static constexpr FieldNode<Root, First, 1> size{};
  static constexpr typename E::template Fields<Root, First + 1> each{};
};

/// The names below an array of structs E.
template <class E, class Root, std::size_t First>
struct ArrayFields : FieldNode<Root, First, leaf_count_of<E>> {
  static constexpr typename E::template Fields<Root, First> each{};
};

}  // namespace sft::detail
