// Payloads as other implementations write them (4 bytes of encapsulation and a body), converted on entry to
// the one encoding that samples have: XCDR1, little-endian.
//
//   00 01             XCDR1, little-endian             taken as it is
//   00 00             XCDR1, big-endian                converted
//   00 07, 00 06      plain XCDR2, little-, big-endian converted
//   00 11, 00 10      the same: XTypes 1.3 numbers it in two ways (tables 60 and 39), and both are in use
//   00 02, 00 03, 00 0a, 00 0b, 00 12, 00 13           parameter lists (mutable types): refused
//   00 08, 00 09, 00 14, 00 15                         delimited XCDR2 (appendable types): refused
//
// XCDR2 aligns 8 bytes to 4, and begins arrays and sequences of anything but primitives (of structs, strings
// and also enumerations) with a delimiter, their length in bytes. Nested types are taken to be final, and an
// array of a type that is itself an array to be one array, as in Cyclone DDS.
//
// What is accepted is the same in every encoding:
//
//   boolean other than 0 and 1                  refused
//   string without NUL, or with one inside      refused
//   string of length 0, not even a NUL          accepted, stays that
//   delimiter that is not the exact length      refused
//   padding between members                     any bytes; zeros where it is converted
//   bytes behind the last member                as many as the last 2 bits of the encapsulation say, and up
//                                               to 3 more: accepted and dropped
//   address of the payload                      any
#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "sft/detail/type_table.h"
#include "sft/detail/walk.h"
#include "sft/result.h"

namespace sft::detail {

/// A payload's body and how it is encoded. Owns nothing.
struct Payload {
  std::span<const std::byte> body;  ///< without the padding that the encapsulation announces; at any address
  std::endian byte_order = std::endian::little;
  bool is_xcdr2 = false;

  bool needs_conversion() const { return is_xcdr2 || byte_order != std::endian::little; }
};

/// Reads the encapsulation. The error names an encoding that is refused, and what to do.
Result<Payload> parse_payload(std::span<const std::byte> payload);

struct ConvertedSize {
  WalkStatus status = WalkStatus::ok;
  std::uint32_t bytes = 0;
};

/// Size of the body that convert() will write: that of the payload's where nothing is converted, otherwise at
/// most 3/2 of it. Reads lengths only.
ConvertedSize converted_size(const Payload& payload, const StructType& type) noexcept;

/// Writes the body, which has converted_size() bytes, and never more. Its lengths and delimiters are those of
/// the payload and lie within it; what else a valid body has to be, build_index() checks.
WalkStatus convert(const Payload& payload, const StructType& type, std::span<std::byte> body) noexcept;

}  // namespace sft::detail
