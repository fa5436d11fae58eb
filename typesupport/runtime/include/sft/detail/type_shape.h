// Types for people: a type as text, and where two definitions of one differ.
#pragma once

#include <cstdint>
#include <string>

#include "sft/type.h"

namespace sft::detail {

/// All structs and enumerations that `type` is made of, each once and before it is used, and `type` last, in
/// the syntax of IDL (without modules: names are whole).
std::string format_shape(const StructType& type);

/// "uint32", "sequence<string<8>, 4>", "double[6]", "pkg::msg::Color": the type of one member.
std::string format_type(const StructType::Member& member);

/// Says in one line where two types differ first: "fields[].offset: uint32 here, uint64 there". Only
/// differences count that structure_hash() tells apart: not the names of types, not units. Empty if nothing
/// differs.
std::string first_difference(const StructType& here, const StructType& there);

/// 64-bit hash of a type's canonical structure: see TypeSupport::hash().
std::uint64_t structure_hash(const StructType& type);

}  // namespace sft::detail
