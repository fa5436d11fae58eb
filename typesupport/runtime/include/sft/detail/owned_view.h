// Copies of structs in a sample, which to_owned() of a generated view returns.
#pragma once

#include <cstddef>

#include "sft/detail/decode.h"
#include "sft/detail/type_table.h"
#include "sft/detail/view.h"
#include "sft/optional.h"

namespace sft::detail {

/// True if any field of the struct at that place can be read: the reader has requested each field, or its
/// samples may lack fields.
template <class Place>
concept has_whole_struct = Place::has_whole;

/// True if the reader has requested each field of the struct, and each sample has all of these fields.
template <class Place>
concept has_declared_struct = Place::has_whole && !Place::may_lack;

/// Copies the struct S at that place. If samples may lack fields, the result is an Optional, which is empty
/// if this sample lacks a field of the struct. If the bytes are malformed, the struct has its default
/// values, and the sample is flagged as malformed.
template <class S, class Place>
auto owned_at(const Place& place) {
  static_assert(sizeof(S) <= (1 << 20), "the struct is too large for the stack: read its fields one by one");
  if constexpr (Place::may_lack) {
    if (!note_leaves(place.state(), Place::first_leaf, leaf_count_of<S>)) return Optional<S>{};
  }
  S value{};
  const auto [state, begin] = place.whole();
  if (decode_struct(*state, TypeTable<S>::type, {Place::first_leaf, begin}, &value) != WalkStatus::ok) {
    place.state().flag_malformed();
    value = S{};
  }
  return Got<Place::requirement, S>{value};
}

}  // namespace sft::detail
