// A message type as a few hundred bytes that travel with its topic: type_description.md. Reading them back is
// DynamicType::parse (dynamic_type.h).
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "sft/typesupport/type_table.h"

namespace sft {

inline constexpr std::uint8_t type_description_version = 1;

/// What is accepted of a description. `leaves` and what follows it count the type expanded: every struct as
/// often as it is used.
struct DescriptionLimits {
  std::size_t bytes = 65'536;
  std::size_t name_bytes = 255;  ///< of each name and unit
  std::uint32_t array_elements = 1U << 28;
  std::size_t depth = 16;            ///< of structs in structs; real types have some 5
  std::size_t leaves = 4096;         ///< as many as a request can name
  std::size_t members = 32'768;      ///< and enumerators
  std::size_t path_bytes = 1 << 20;  ///< of the paths of all leaves, about
};

/// Equal types have equal descriptions. Time and bytes grow with the structs that there are, not with how
/// often they are used.
std::vector<std::byte> describe(const StructType& type);

}  // namespace sft
