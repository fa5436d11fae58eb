// This file says a second time, and in the plainest way, what masks mean, to compare the runtime with.
// Numbers of leaves, closed masks, the projected value and its CDR follow from the sentences of the design;
// nothing of the runtime is used but the tables.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "sft/detail/type_table.h"
#include "sft/mask.h"
#include "tests/support/owned_value.h"

namespace sft::test::reference {

std::size_t leaves(const StructType& type);

/// `mask` with the lengths of all sequences of which it has a leaf, and the message's key members.
FieldMask closed(const StructType& type, FieldMask mask);

/// Copies the leaves in `mask` (closed) from one value to the other, which keeps its other leaves.
void project(const OwnedValue& from, const FieldMask& mask, OwnedValue& to);

/// XCDR1, little-endian, of the struct that has only the members in `mask` (closed), without encapsulation.
std::vector<std::byte> cdr(const OwnedValue& value, const FieldMask& mask);

/// Returns true if `bytes` are that CDR, apart from what other writers do: any bytes as padding, empty
/// strings of length 0.
bool is_cdr_of(std::span<const std::byte> bytes, const OwnedValue& value, const FieldMask& mask);

}  // namespace sft::test::reference
