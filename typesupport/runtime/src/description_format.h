// The bits of a member's form and attributes in a type description (type_description.md), for the code that
// writes it and the code that reads it.
#pragma once

namespace sft::description {

inline constexpr unsigned kind_bits = 0x0f;
inline constexpr unsigned shape_shift = 4;
inline constexpr unsigned shape_bits = 0x03;
inline constexpr unsigned is_key = 0x40;
inline constexpr unsigned has_attributes = 0x80;

inline constexpr unsigned has_bound = 0x01;
inline constexpr unsigned has_string_bound = 0x02;
inline constexpr unsigned has_enumeration = 0x04;
inline constexpr unsigned has_unit = 0x08;
inline constexpr unsigned has_layout = 0x10;
inline constexpr unsigned attribute_bits = 0x1f;

}  // namespace sft::description
