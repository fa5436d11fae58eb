// Writes the bytes of a selection (selection.md, "Bytes"). Numbers are in LEB128; selection.md specifies
// everything else.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "sft/selection.h"

namespace sft::detail {

/// Appends one condition without its children.
void put(std::vector<std::byte>& out, const Selection::Condition& condition);

std::vector<std::byte> bytes_of(std::span<const Selection::Part> parts);
std::vector<std::byte> bytes_of(const Selection::Gate& gate);

}  // namespace sft::detail
