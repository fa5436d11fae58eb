// Only generated code includes this file: it has the parts that a table, field names and views are made of.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sft/detail/loan_view.h"
#include "sft/detail/type_table.h"
#include "sft/detail/view.h"
#include "sft/mask.h"

namespace sft::detail {

/// Base of the generated names of S's fields, S being at leaf First of Root: S's own node, and nodes for its
/// members.
template <class Root, std::size_t First, class S>
struct FieldsOf : FieldNode<Root, First, leaf_count_of<S>> {
  template <std::size_t M>
  static constexpr std::size_t first = First + leaf_offset(TypeTable<S>::type, M);
  template <std::size_t M>
  using Leaf = FieldNode<Root, first<M>, leaf_count(TypeTable<S>::members[M])>;
};

/// Names below a sequence of structs E: `fields` is all of it, `fields.size` its length, `fields.each.name` a
/// leaf of the elements (written `fields[].name` in text).
template <class E, class Root, std::size_t First>
struct SequenceFields : FieldNode<Root, First, 1 + leaf_count_of<E>> {
  static constexpr FieldNode<Root, First, 1> size{};
  static constexpr typename E::template Fields<Root, First + 1> each{};
};

/// Names below an array of structs E.
template <class E, class Root, std::size_t First>
struct ArrayFields : FieldNode<Root, First, leaf_count_of<E>> {
  static constexpr typename E::template Fields<Root, First> each{};
};

}  // namespace sft::detail
