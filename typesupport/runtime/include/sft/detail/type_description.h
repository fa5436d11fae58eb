// Describes a message type in a few hundred bytes, which are announced with its topic
// (type_description.md). DynamicType::parse (dynamic_type.h) reads them.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "sft/type.h"

namespace sft::detail {

inline constexpr std::uint8_t type_description_version = 1;

/// Returns the description of a type. Equal types have equal descriptions. Time and bytes grow with the
/// number of different structs, not with the number of their uses.
std::vector<std::byte> describe(const StructType& type);

}  // namespace sft::detail
