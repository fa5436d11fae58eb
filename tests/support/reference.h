// A second, simple implementation of masks, with which the runtime is compared. It computes numbers of
// leaves, closed masks, the projected value and its CDR as the design defines them, and uses nothing of the
// runtime except the tables.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "sft/detail/type_table.h"
#include "sft/mask.h"
#include "tests/support/owned_value.h"

namespace sft::test::reference {

std::size_t leaves(const StructType& type);

/// Returns `mask` with the lengths of all sequences of which it has a leaf, and with the message's key
/// members.
FieldMask closed(const StructType& type, FieldMask mask);

/// Copies the leaves in `mask` (closed) to the value `to`, which keeps its other leaves.
void project(const OwnedValue& from, const FieldMask& mask, OwnedValue& to);

/// Returns XCDR1, little-endian and without encapsulation, of the struct that has only the members in `mask`
/// (closed).
std::vector<std::byte> cdr(const OwnedValue& value, const FieldMask& mask);

/// Returns true if `bytes` are that CDR. Like the output of other writers, they may have any bytes as
/// padding, and empty strings of length 0.
bool is_cdr_of(std::span<const std::byte> bytes, const OwnedValue& value, const FieldMask& mask);

}  // namespace sft::test::reference
