// A message type as a few hundred bytes that travel with its topic: type_description.md. Reading them back is
// DynamicType::parse (dynamic_type.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "sft/type.h"

namespace sft::detail {

inline constexpr std::uint8_t type_description_version = 1;

/// Equal types have equal descriptions. Time and bytes grow with the structs that there are, not with how
/// often they are used.
std::vector<std::byte> describe(const StructType& type);

}  // namespace sft::detail
