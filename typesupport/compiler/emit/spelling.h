// Types and values of the model as C++ source text.
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

/// "sft::detail::Kind::int32".
std::string kind_name(sft_kind kind);

/// Of one element in the owned struct. A boolean in an array or a sequence is its byte, as in views.
std::string element_type(const sft_type& type);

/// Of a member of the owned struct: an element, or std::array or std::vector of them.
std::string owned_type(const sft_type& type);

/// Of a constant: as owned, but a string is a std::string_view.
std::string constant_type(const sft_type& type);

/// A literal, the qualified name of an enumerator, or a bitmask made of its integer.
std::string value_text(const sft_type& type, const sft_value& value);
std::string natural_text(std::uint64_t value);

/// What a member of the owned struct starts with, from the '=' or '{' on.
std::string initializer(const sft_member& member);

/// With quotes and escapes.
std::string string_literal(std::string_view text);

}  // namespace sft::idl
