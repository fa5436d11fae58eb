// A type as text for people, and the difference between two definitions of a type.
#pragma once

#include <cstdint>
#include <string>

#include "sft/type.h"

namespace sft::detail {

/// Returns the text of all structs and enumerations of which `type` is made, each once and before its first
/// use, and `type` last, in the syntax of IDL (without modules: names are whole).
std::string format_shape(const StructType& type);

/// Returns the type of one member as text: "uint32", "sequence<string<8>, 4>", "double[6]",
/// "pkg::msg::Color".
std::string format_type(const StructType::Member& member);

/// Returns the first difference of two types in one line: "fields[].offset: uint32 here, uint64 there".
/// Only differences that change structure_hash() count: the names of types and the units do not count.
/// Empty if nothing differs.
std::string first_difference(const StructType& here, const StructType& there);

/// Returns a 64-bit hash of a type's canonical structure: see TypeSupport::hash().
std::uint64_t structure_hash(const StructType& type);

}  // namespace sft::detail
