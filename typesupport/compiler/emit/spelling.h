// Writes types and values of the model as C++ source text.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "model.h"

namespace sft::idl {

bool is_single(const sft_type& type);
bool is_structure(const sft_type& type);
bool is_enumeration(const sft_type& type);
bool is_bitmask(const sft_type& type);

/// Returns the name of a kind in generated code: "sft::detail::Kind::int32".
std::string kind_name(sft_kind kind);

/// Returns the C++ type of one element in the owned struct. A boolean in an array or a sequence is a byte, as
/// in views.
std::string element_type(const sft_type& type);

/// Returns the C++ type of a member of the owned struct: an element, or a std::array or std::vector of
/// elements.
std::string owned_type(const sft_type& type);

/// Returns the C++ type of a constant: the owned type, except std::string_view for strings.
std::string constant_type(const sft_type& type);

/// Returns a value in C++: a literal, the qualified name of an enumerator, or a bitmask made from its
/// integer.
std::string value_text(const sft_type& type, const sft_value& value);
std::string natural_text(std::uint64_t value);

/// Returns the initializer of a member of the owned struct, with its '=' or '{'.
std::string initializer(const sft_member& member);

/// Returns the text as a C++ string literal.
std::string string_literal(std::string_view text);

}  // namespace sft::idl
