// A second, simple implementation of masks, with which the runtime is compared. It computes numbers of
// leaves, closed masks, the projected value and its CDR as the design defines them. It uses nothing of the
// runtime except the type tables.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "sft/detail/type_table.h"
#include "sft/mask.h"
#include "tests/support/owned_value.h"

namespace sft::test::reference {

std::size_t leaves(const StructType& type);

/// Returns `mask` with two additions: the lengths of all sequences of which the mask has a leaf, and the
/// message's key members.
FieldMask closed(const StructType& type, FieldMask mask);

/// Copies the leaves in `mask`, which must be closed, to the value `to`. The other leaves of `to` stay
/// unchanged.
void project(const OwnedValue& from, const FieldMask& mask, OwnedValue& to);

/// Returns the XCDR1, little-endian and without encapsulation, of the struct that has only the members in
/// `mask`, which must be closed.
std::vector<std::byte> cdr(const OwnedValue& value, const FieldMask& mask);

/// Returns true if `bytes` are the CDR of the members in `mask`. `bytes` may have any padding, and empty
/// strings of length 0, because other writers may send these.
bool is_cdr_of(std::span<const std::byte> bytes, const OwnedValue& value, const FieldMask& mask);

}  // namespace sft::test::reference
